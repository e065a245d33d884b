// The audit log in a file of its own, as the daemon writes it.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "common/audit_file.h"
#include "common/log.h"

namespace gnomon::log {
namespace {

namespace fs = std::filesystem;

class AuditLog : public testing::Test {
 protected:
  void SetUp() override {
    std::string folder = (fs::temp_directory_path() / "gnomon_audit_XXXXXX").string();
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
    file_ = folder_ / "audit.log";
  }
  void TearDown() override {
    configure(Level::warning, Format::key_value);
    EXPECT_TRUE(set_audit_file(""));
    fs::remove_all(folder_);
  }
  void open() {
    const auto opened = set_audit_file(file_.string());
    ASSERT_TRUE(opened) << opened.error().message;
  }
  static std::string text_of(const fs::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  }
  static size_t lines_of(const fs::path& file) {
    const std::string text = text_of(file);
    return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
  }

  fs::path folder_, file_;
};

TEST_F(AuditLog, IsWrittenAtEveryLevelUnderItsOwnName) {
  configure(Level::off, Format::key_value);
  open();
  audit("action", {{"operator", "root(0)"}, {"target", ""}, {"reason", "a b"}});
  EXPECT_NE(text_of(file_).find(" audit action operator=root(0) target=\"\" reason=\"a b\"\n"), std::string::npos)
      << text_of(file_);
  struct stat info {};
  ASSERT_EQ(stat(file_.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07137u, 0u) << "not for others, nor to be written by the group";
}

// RFC 3339, so that lines of nodes in different zones can be compared.
TEST_F(AuditLog, TimesNameTheirZone) {
  setenv("TZ", "Asia/Kolkata", 1);
  tzset();
  for (const Format format : {Format::key_value, Format::json}) {
    configure(Level::info, format);
    testing::internal::CaptureStderr();
    open();
    audit("action");
    info("something");
    const std::regex time(R"(^(\{"time":")?\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}\+05:30[" ])");
    EXPECT_TRUE(std::regex_search(text_of(file_), time)) << text_of(file_);
    const std::string others = testing::internal::GetCapturedStderr();
    EXPECT_TRUE(std::regex_search(others, time)) << others;
    fs::remove(file_);
  }
  unsetenv("TZ");
  tzset();
}

TEST_F(AuditLog, IsJsonWhereTheOtherLinesAre) {
  configure(Level::info, Format::json);
  open();
  audit("action", {{"operator", "root(0)"}});
  EXPECT_NE(text_of(file_).find(R"x("level":"info","logger":"audit","event":"action","operator":"root(0)"})x"),
            std::string::npos)
      << text_of(file_);
}

TEST_F(AuditLog, NoLineHasControlsOrASecondLineWhateverWasSent) {
  open();
  audit("action", {{"target", "a\nb\xc2\x9b\x33\x31m\x9b\u202e"}});
  EXPECT_EQ(lines_of(file_), 1u);
  EXPECT_NE(text_of(file_).find(R"(target="a\u000ab\u009b31m\ufffd\u202e")"), std::string::npos) << text_of(file_);
}

TEST_F(AuditLog, IsOpenedAnewAfterARotationAndAppends) {
  open();
  audit("action", {{"number", 1}});
  fs::rename(file_, folder_ / "audit.log.1");
  audit("action", {{"number", 2}});
  open();
  audit("action", {{"number", 3}});
  open();
  audit("action", {{"number", 4}});
  EXPECT_EQ(lines_of(folder_ / "audit.log.1"), 2u);
  EXPECT_EQ(lines_of(file_), 2u);
}

TEST_F(AuditLog, AFileThatCannotBeWrittenIsAnErrorAndTheLogStaysWhereItWas) {
  open();
  const auto failed = set_audit_file((folder_ / "nowhere" / "audit.log").string());
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("nowhere"), std::string::npos);
  audit("action");
  EXPECT_EQ(lines_of(file_), 1u);
}

// It goes where it would go without a file, at every level, and is counted.
TEST_F(AuditLog, WhatAFullDiskDoesNotTakeStandsInTheLog) {
  configure(Level::warning, Format::key_value);
  ASSERT_TRUE(set_audit_file("/dev/full"));
  const uint64_t before = unwritten_audit().lines;
  testing::internal::CaptureStderr();
  audit("action", {{"number", 1}});
  audit("action", {{"number", 2}});
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(std::regex_search(log, std::regex(" audit action number=1\n.* error audit log not written "
                                                "file=/dev/full why=\"No space left on device\"\n.* audit action "
                                                "number=2\n")))
      << log;
  EXPECT_EQ(unwritten_audit().lines, before + 2);
  EXPECT_EQ(unwritten_audit().why, "No space left on device");
  open();
  EXPECT_EQ(unwritten_audit().why, "") << "that was of the other file";
  audit("action", {{"number", 3}});
  EXPECT_EQ(unwritten_audit().lines, before + 2);
  EXPECT_EQ(lines_of(file_), 1u);
}

// The system takes a part of the line that fills the disk; a limit of files' sizes does the same.
TEST_F(AuditLog, WithRoomAgainALineBeginsAfterThePartOfTheOneThatFilledTheDisk) {
  open();
  audit("first");
  const auto size = fs::file_size(file_);
  const auto told_before = std::signal(SIGXFSZ, SIG_IGN);
  rlimit as_it_was{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &as_it_was), 0);
  const rlimit full{size + 5, as_it_was.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &full), 0);
  testing::internal::CaptureStderr();
  audit("second");
  setrlimit(RLIMIT_FSIZE, &as_it_was);
  const std::string log = testing::internal::GetCapturedStderr();
  std::signal(SIGXFSZ, told_before);
  EXPECT_NE(log.find(" audit second\n"), std::string::npos) << log;
  EXPECT_NE(unwritten_audit().why, "");
  audit("third");
  EXPECT_EQ(unwritten_audit().why, "");
  EXPECT_EQ(lines_of(file_), 3u);
  EXPECT_TRUE(std::regex_search(text_of(file_), std::regex(" audit first\n.{5}\n.* audit third\n$")))
      << text_of(file_);
}

// Strangers cause refusals as fast as they like; what operators do is few and never left out.
TEST_F(AuditLog, RefusalsAreLimitedInRateAndActionsAreNot) {
  open();
  constexpr int kMany = 1000;
  for (int i = 0; i < kMany; ++i) audit_refusal("refused");
  EXPECT_LT(lines_of(file_), size_t{kMany} / 2);
  const size_t before = lines_of(file_);
  for (int i = 0; i < kMany; ++i) audit("action");
  EXPECT_EQ(lines_of(file_), before + kMany);
}

TEST_F(AuditLog, AnotherFormatHoldsForItAndForTheLogFromThenOn) {
  configure(Level::info, Format::key_value);
  open();
  audit("first");
  testing::internal::CaptureStderr();
  info("one", {{"key", "a"}});
  configure(Level::info, Format::json);
  audit("second", {{"operator", "root"}});
  info("two", {{"key", "b"}});
  configure(Level::warning, Format::key_value);
  audit("third");
  info("three");
  warning("four");
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(std::regex_search(
      log, std::regex("info one key=a\n.*\"level\":\"info\",\"event\":\"two\",\"key\":\"b\"\\}\n.*warning four\n")))
      << log;
  EXPECT_EQ(log.find("three"), std::string::npos);
  const std::string text = text_of(file_);
  EXPECT_TRUE(std::regex_search(
      text, std::regex(" audit first\n\\{.*\"logger\":\"audit\",\"event\":\"second\",\"operator\":\"root\"\\}\n.* "
                       "audit third\n")))
      << text;
}

}  // namespace
}  // namespace gnomon::log
