#include "apps/common/rate_text.h"

#include <cmath>

#include "apps/common/text.h"

namespace accel::apps {

std::string rate_text(const validation::Rate& rate) {
  if (std::isnan(rate.per_million)) return "\u2013";
  return rate.per_million > 0 ? short_number(rate.per_million) : "< " + short_number(rate.bound95_per_million);
}

}  // namespace accel::apps
