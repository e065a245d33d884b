// What becomes of lines whose reader stops, and comes again.
#include "common/patient_stream.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>

namespace gnomon::log {
namespace {

struct Ends {
  int reader = -1, writer = -1;
  ~Ends() {
    close(reader);
    close(writer);
  }
  // All that is there.
  std::string take() const {
    std::string all;
    std::array<char, 65536> bytes{};
    fcntl(reader, F_SETFL, O_NONBLOCK);
    for (ssize_t got; (got = read(reader, bytes.data(), bytes.size())) > 0;)
      all.append(bytes.data(), static_cast<size_t>(got));
    return all;
  }
};

class PatientStreamTest : public testing::TestWithParam<bool> {
 protected:
  PatientStreamTest() {
    int pair[2];
    EXPECT_EQ(GetParam() ? socketpair(AF_UNIX, SOCK_STREAM, 0, pair) : pipe(pair), 0);
    ends_.reader = pair[0], ends_.writer = pair[1];
  }
  Ends ends_;
};

TEST_P(PatientStreamTest, NobodyIsHeldUpWhileNothingIsRead) {
  PatientStream stream(ends_.writer);
  size_t taken = 0;
  while (stream.write("line " + std::to_string(taken) + std::string(200, '.') + "\n")) ++taken;
  EXPECT_GT(taken, 100u);
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(stream.write(std::string(10'000, 'x') + "\n"));
  const std::string before = ends_.take();
  EXPECT_NE(before.find("line 99"), std::string::npos);
  EXPECT_TRUE(stream.write("again\n"));
  EXPECT_EQ(("\n" + before.substr(before.rfind('\n') + 1) + ends_.take()).find("xagain"), std::string::npos)
      << "it begins a line";
}

TEST_P(PatientStreamTest, LongLinesComeWhole) {
  PatientStream stream(ends_.writer);
  const std::string line = std::string(20'000, 'y') + "\n";
  EXPECT_TRUE(stream.write(line));
  EXPECT_EQ(ends_.take(), line);
}

INSTANTIATE_TEST_SUITE_P(PipesAndSockets, PatientStreamTest, testing::Bool());

}  // namespace
}  // namespace gnomon::log
