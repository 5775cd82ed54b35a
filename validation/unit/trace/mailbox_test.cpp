#include "libaccel/trace/mailbox.h"

#include <gtest/gtest.h>

namespace accel {
namespace {

TEST(Mailbox, RemembersTheLastFew) {
  Mailbox<3> mailbox;
  mailbox.clear();
  EXPECT_FALSE(mailbox.remember(5));
  EXPECT_TRUE(mailbox.remember(5));
  EXPECT_FALSE(mailbox.remember(0));
  EXPECT_FALSE(mailbox.remember(7));
  EXPECT_TRUE(mailbox.remember(5)) << "still among the last three";
  EXPECT_FALSE(mailbox.remember(8));
  EXPECT_FALSE(mailbox.remember(5)) << "the oldest was forgotten";
  mailbox.clear();
  EXPECT_FALSE(mailbox.remember(5));
}

TEST(Mailbox, NoneRemembersNothing) {
  NoMailbox mailbox;
  mailbox.clear();
  EXPECT_FALSE(mailbox.remember(5));
  EXPECT_FALSE(mailbox.remember(5));
}

}  // namespace
}  // namespace accel
