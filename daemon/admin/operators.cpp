#include "daemon/admin/operators.h"

#include <grp.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace gnomon::daemon {
namespace {

constexpr size_t kRecordBytes = 16 * 1024;  // of an account or a group with many members

}  // namespace

Result<std::optional<gid_t>> group_of(const std::string& name) {
  if (name.empty()) return std::optional<gid_t>();
  std::vector<char> text(kRecordBytes);
  group record{};
  group* found = nullptr;
  while (getgrnam_r(name.c_str(), &record, text.data(), text.size(), &found) == ERANGE)
    text.resize(2 * text.size());
  if (!found) return Error{"admin.group: this machine has no group " + name};
  return std::optional<gid_t>(found->gr_gid);
}

bool may_change(const PeerCredentials& process, std::optional<gid_t> group) {
  if (process.uid == 0 || process.uid == geteuid()) return true;
  return group && std::find(process.groups.begin(), process.groups.end(), *group) != process.groups.end();
}

std::string account_name(uid_t uid) {
  std::array<char, kRecordBytes> text;
  passwd record{};
  passwd* found = nullptr;
  getpwuid_r(uid, &record, text.data(), text.size(), &found);
  return (found ? std::string(found->pw_name) : "uid") + "(" + std::to_string(uid) + ")";
}

}  // namespace gnomon::daemon
