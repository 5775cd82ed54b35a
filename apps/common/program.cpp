#include "apps/common/program.h"

#include <csignal>
#include <exception>
#include <new>

#include "apps/common/interrupt.h"

namespace accel::apps {

namespace {

Outcome<ExitStatus> run_body(Terminal& terminal, const std::function<Outcome<ExitStatus>(Terminal&)>& body) {
  try {
    return body(terminal);
  } catch (const std::bad_alloc&) {
    return Failure(ExitStatus::error, "out of memory; use a smaller scene or fewer rays");
  } catch (const std::exception& exception) {
    return Failure(ExitStatus::error, exception.what());
  }
}

}  // namespace

int run_program(const std::string& name, const std::function<Outcome<ExitStatus>(Terminal&)>& body) {
  std::signal(SIGPIPE, SIG_IGN);  // a closed pipe is a write error
  catch_interrupts();
  Terminal terminal(name);
  const auto status = run_body(terminal, body);
  if (status) return static_cast<int>(*status);
  terminal.error(status.failure().message);
  return static_cast<int>(status.failure().status);
}

Outcome<ExitStatus> answer(const Terminal& terminal, std::string_view text) {
  auto written = terminal.write(text);
  if (!written) return written.failure();
  return ExitStatus::ok;
}

}  // namespace accel::apps
