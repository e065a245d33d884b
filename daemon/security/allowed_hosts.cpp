#include "daemon/security/allowed_hosts.h"

#include <algorithm>
#include <cctype>

namespace gnomon::daemon {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return std::tolower(c); });
  return out;
}

struct Authority {
  std::string name;  // an IPv6 address without its brackets
  std::string port;  // empty if none is named

  friend bool operator==(const Authority&, const Authority&) = default;
};

Authority authority_of(std::string_view text) {
  const bool bracketed = text.starts_with('[');
  const size_t end = bracketed ? text.find(']') : text.find(':');
  if (end == std::string_view::npos) return {lower(text), ""};
  const std::string name = lower(bracketed ? text.substr(1, end - 1) : text.substr(0, end));
  const std::string_view rest = text.substr(bracketed ? end + 1 : end);
  return {name, std::string(rest.starts_with(':') ? rest.substr(1) : rest)};
}

Authority with_port(Authority authority, bool encrypted) {
  if (authority.port.empty()) authority.port = encrypted ? "443" : "80";
  return authority;
}

bool matches(const std::string& pattern, const std::string& name) {
  if (!pattern.starts_with("*.")) return pattern == name;
  const size_t dot = name.find('.');
  return dot != std::string::npos && dot > 0 && name.substr(dot) == pattern.substr(1);
}

std::string_view scheme_of(bool encrypted) { return encrypted ? "https://" : "http://"; }

}  // namespace

bool AllowedHosts::allows_host(std::string_view host, const ReachedAt& reached) const {
  const Authority asked = with_port(authority_of(host), reached.encrypted);
  if (asked.name.empty()) return false;
  const bool ours = asked.name == "localhost" || asked.name == reached.address;
  if (ours && asked.port == std::to_string(reached.port)) return true;
  return std::any_of(configured_.begin(), configured_.end(), [&](const std::string& text) {
    // An IPv6 address without brackets, as certificates have it, names no port.
    const bool address = std::count(text.begin(), text.end(), ':') > 1 && !text.starts_with('[');
    const Authority known = address ? Authority{lower(text), ""} : authority_of(text);
    return matches(known.name, asked.name) && (known.port.empty() || known.port == asked.port);
  });
}

bool AllowedHosts::allows_origin(std::string_view origin, const ReachedAt& reached) const {
  const std::string_view scheme = scheme_of(reached.encrypted);
  return origin.starts_with(scheme) && allows_host(origin.substr(scheme.size()), reached);
}

bool is_same_origin(std::string_view origin, std::string_view host, bool encrypted) {
  const std::string_view scheme = scheme_of(encrypted);
  if (!origin.starts_with(scheme) || host.empty()) return false;
  return with_port(authority_of(origin.substr(scheme.size())), encrypted) ==
         with_port(authority_of(host), encrypted);
}

}  // namespace gnomon::daemon
