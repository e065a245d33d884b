#include "client/cli/waiting_line.h"

#include <cmath>
#include <utility>
#include <variant>

#include "common/printable.h"

namespace gnomon::client {

std::string describe(const protocol::Waiting& waiting) {
  std::string line = without_controls(waiting.text);
  if (waiting.percent != protocol::Waiting::kUnknown) line += ", " + std::to_string(waiting.percent) + "%";
  return line;
}

WaitingLine::WaitingLine(Progress& progress, std::string server)
    : progress_(progress), server_(std::move(server)) {}

void WaitingLine::heard(const protocol::Message& message) {
  const auto* const waiting = std::get_if<protocol::Waiting>(&message);
  if (!waiting) return;
  const TimePoint now = Clock::now();
  if (waiting->text == shown_ && !progress_.due(now)) return;
  shown_ = waiting->text;
  const auto seconds = static_cast<uint64_t>(std::lround(to_seconds(now - since_)));
  progress_.show("waiting for " + server_ + ": " + describe(*waiting) + " (" + std::to_string(seconds) + " s)",
                 now);
}

}  // namespace gnomon::client
