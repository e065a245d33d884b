#include "client/load/load_plan.h"

#include <charconv>

#include "client/cli/options.h"

namespace gnomon::client {

namespace {

constexpr size_t kMostClients = 100'000;

}  // namespace

Result<LoadGroup> parse_group(std::string_view text) {
  const Error malformed{std::string("'").append(text) + "' is no NAME:TOKENFILE:CLIENTS, such as arcade::4"};
  const size_t first = text.find(':');
  const size_t last = text.rfind(':');
  if (first == std::string_view::npos || first == last) return malformed;
  LoadGroup group;
  group.tenant = text.substr(0, first);
  const std::string_view count = text.substr(last + 1);
  const auto [end, error] = std::from_chars(count.data(), count.data() + count.size(), group.clients);
  if (group.tenant.empty() || error != std::errc{} || end != count.data() + count.size() || group.clients == 0) {
    return malformed;
  }
  group.token_file = text.substr(first + 1, last - first - 1);
  return group;
}

Result<std::vector<size_t>> parse_clients(std::string_view text) {
  constexpr std::string_view kTo = "..";
  const Error malformed{std::string("--clients: '").append(text) +
                        "' is neither a number of clients, such as 8, nor a sweep, such as 1..64"};
  const size_t split = text.find(kTo);
  const auto number = [](std::string_view part) {
    size_t value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size() ? value : 0;
  };
  const size_t first = number(text.substr(0, split));
  const size_t last = split == std::string_view::npos ? first : number(text.substr(split + kTo.size()));
  if (first == 0 || last < first || last > kMostClients) return malformed;
  std::vector<size_t> runs;
  for (size_t clients = first; clients < last; clients *= 2) runs.push_back(clients);
  runs.push_back(last);
  return runs;
}

Result<std::vector<LoadGroup>> plan_load(const std::vector<std::string>& groups, size_t clients) {
  if (groups.empty()) {
    if (clients == 0) return Error{"--clients is missing: how many clients?"};
    return std::vector{LoadGroup{.clients = clients}};
  }
  std::vector<LoadGroup> plan;
  size_t sum = 0;
  for (const std::string& text : groups) {
    auto group = parse_group(text);
    if (!group) return group.error();
    sum += group->clients;
    plan.push_back(std::move(*group));
  }
  if (clients != 0 && clients != sum) {
    return Error{"--clients " + std::to_string(clients) + " but the tenants have " + std::to_string(sum)};
  }
  return plan;
}

Result<void> read_tokens(std::vector<LoadGroup>& plan) {
  for (LoadGroup& group : plan) {
    if (group.token_file.empty()) continue;
    auto token = read_token(group.token_file);
    if (!token) return token.error();
    group.token = std::move(*token);
  }
  return {};
}

}  // namespace gnomon::client
