#include "tests/tools/netsim/profile.h"

#include <charconv>
#include <cmath>
#include <optional>

namespace gnomon::netsim {
namespace {

struct Unit {
  std::string_view name;
  double factor;
};

// A number and one of the units; without a unit, the first one applies.
std::optional<double> number(std::string_view text, std::initializer_list<Unit> units) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || !std::isfinite(value) || value < 0) return std::nullopt;
  const std::string_view rest = text.substr(static_cast<size_t>(end - text.data()));
  for (const Unit& unit : units) {
    if (rest == unit.name) return value * unit.factor;
  }
  return std::nullopt;
}

Error amiss(std::string_view what, std::string_view text, std::string_view wanted) {
  return Error{std::string("'").append(text).append("' is no ").append(what).append(", such as ").append(wanted)};
}

Result<void> set(Nanoseconds& to, std::string_view text) {
  const auto parsed = parse_time(text);
  if (!parsed) return parsed.error();
  to = *parsed;
  return {};
}

Result<void> set(double& to, const Result<double>& parsed) {
  if (!parsed) return parsed.error();
  to = *parsed;
  return {};
}

Result<void> set_burst(Profile& profile, std::string_view text) {
  const size_t colon = text.find(':');
  if (colon == std::string_view::npos) return amiss("pair of chances", text, "1%:30%");
  if (auto enter = set(profile.burst_enter, parse_share(text.substr(0, colon))); !enter) return enter;
  return set(profile.burst_leave, parse_share(text.substr(colon + 1)));
}

Result<void> set_queue(Profile& profile, std::string_view text) {
  if (auto time = parse_time(text)) {
    profile.queue = *time;
    profile.queue_bytes = 0;
    return {};
  }
  const auto bytes = number(text, {{"b", 1}, {"kb", 1e3}, {"mb", 1e6}});
  if (!bytes) return amiss("queue", text, "100ms or 64kb");
  profile.queue_bytes = static_cast<size_t>(*bytes);
  profile.queue = Nanoseconds::max();
  return {};
}

Result<void> set_mtu(Profile& profile, std::string_view text) {
  const auto bytes = number(text, {{"", 1}, {"b", 1}});
  if (!bytes) return amiss("length of a datagram", text, "1280");
  profile.mtu = static_cast<size_t>(*bytes);
  return {};
}

Result<void> set_udp(Profile& profile, std::string_view text) {
  if (text != "on" && text != "off") return amiss("choice", text, "on or off");
  profile.udp = text == "on";
  return {};
}

Result<void> set_one(std::string_view key, std::string_view value, Profile& profile) {
  if (key == "delay") return set(profile.delay, value);
  if (key == "jitter") return set(profile.jitter, value);
  if (key == "loss") return set(profile.loss, parse_share(value));
  if (key == "burst") return set_burst(profile, value);
  if (key == "reorder") return set(profile.reorder, parse_share(value));
  if (key == "reorder_by") return set(profile.reorder_by, value);
  if (key == "duplicate") return set(profile.duplicate, parse_share(value));
  if (key == "mtu") return set_mtu(profile, value);
  if (key == "udp") return set_udp(profile, value);
  if (key == "rate") return set(profile.rate_bit_per_s, parse_rate(value));
  if (key == "queue") return set_queue(profile, value);
  return amiss("property of a link", key,
               "delay, jitter, loss, burst, reorder, reorder_by, duplicate, rate, queue, mtu, udp");
}

}  // namespace

Result<Nanoseconds> parse_time(std::string_view text) {
  const auto ns = number(text, {{"ms", 1e6}, {"us", 1e3}, {"s", 1e9}, {"ns", 1}});
  if (!ns || *ns > 1e15) return amiss("time", text, "50ms, 200us or 1.5s");
  return Nanoseconds(static_cast<int64_t>(std::llround(*ns)));
}

Result<double> parse_share(std::string_view text) {
  const auto share = number(text, {{"", 1}, {"%", 0.01}});
  if (!share || *share > 1) return amiss("share", text, "2% or 0.02");
  return *share;
}

Result<double> parse_rate(std::string_view text) {
  const auto rate = number(text, {{"bit", 1}, {"kbit", 1e3}, {"mbit", 1e6}, {"gbit", 1e9}});
  if (!rate) return amiss("rate", text, "20mbit or 500kbit");
  return *rate;
}

Result<void> apply(std::string_view text, Profile& profile) {
  while (!text.empty()) {
    const size_t comma = std::min(text.find(','), text.size());
    const std::string_view item = text.substr(0, comma);
    text.remove_prefix(std::min(comma + 1, text.size()));
    const size_t equals = item.find('=');
    if (equals == std::string_view::npos) return amiss("KEY=VALUE", item, "delay=50ms");
    if (auto done = set_one(item.substr(0, equals), item.substr(equals + 1), profile); !done) return done;
  }
  return {};
}

}  // namespace gnomon::netsim
