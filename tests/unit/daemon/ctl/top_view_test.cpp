// The live table of gnomonctl without a terminal: what keys do to what is shown.
#include "daemon/ctl/top_view.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/ctl/scene_load.h"

namespace gnomon::ctl {
namespace {

using nlohmann::json;

// Sessions 0 to count - 1, session i with i frames and of tenant lab or arcade in turn.
json status(int count, int frames_each) {
  json sessions = json::array();
  for (int i = 0; i < count; ++i) {
    sessions.push_back({{"id", std::to_string(1000 + i)},
                        {"tenant", i % 2 ? "lab" : "arcade"},
                        {"scene", "temple"},
                        {"width", 640},
                        {"height", 360},
                        {"frames", i * frames_each},
                        {"queue_us", 1000 * (count - i)}});
  }
  return {{"version", "1"},
          {"ready", true},
          {"sessions", sessions},
          {"tenants", {{{"name", "lab"}}, {{"name", "arcade"}}}}};
}

class Top : public testing::Test {
 protected:
  std::vector<std::string> screen(size_t rows = 24, size_t columns = 200) {
    return view_.screen(top_tables({before_, now_, 1.0}, view_.order()), rows, columns);
  }
  // The ids of the sessions on the screen, from the top.
  std::vector<int> shown(size_t rows = 24) {
    std::vector<int> ids;
    for (const std::string& line : screen(rows)) {
      if (line.starts_with("10")) ids.push_back(std::stoi(line));
    }
    return ids;
  }
  void type(const std::string& text) {
    for (const char c : text) EXPECT_TRUE(view_.press(TopKey::character, c));
  }

  json before_ = status(40, 0), now_ = status(40, 1);
  TopView view_;
};

TEST_F(Top, TheBusiestComeFirstAndTheRestIsToldOf) {
  const auto ids = shown();
  ASSERT_FALSE(ids.empty());
  EXPECT_LT(ids.size(), 40u);
  EXPECT_EQ(ids.front(), 1039);
  EXPECT_EQ(screen().back(), "sessions 1 to " + std::to_string(ids.size()) + " of 40   ? help  q leave");
  EXPECT_EQ(screen().size(), 24u);
}

TEST_F(Top, RowsScrollToTheEndAndBack) {
  const size_t page = shown().size();
  view_.press(TopKey::down);
  EXPECT_EQ(shown().front(), 1038);
  view_.press(TopKey::page_down);
  EXPECT_EQ(shown().front(), 1038 - static_cast<int>(page));
  view_.press(TopKey::end);
  EXPECT_EQ(shown().back(), 1000);
  view_.press(TopKey::page_down);
  EXPECT_EQ(shown().back(), 1000) << "there is nothing beyond";
  EXPECT_EQ(shown().size(), page);
  view_.press(TopKey::home);
  EXPECT_EQ(shown().front(), 1039);
}

TEST_F(Top, SortsByTheColumnThatIsChosen) {
  view_.press(TopKey::right);  // from vbps to queue, which is longest for the first
  EXPECT_EQ(shown().front(), 1000);
  type("r");
  EXPECT_EQ(shown().front(), 1039);
  while (view_.order().by != SessionColumn::session) view_.press(TopKey::left);
  EXPECT_EQ(shown().front(), 1000) << "names from the first on";
}

TEST_F(Top, AFilterLeavesOutWhatLacksItsText) {
  type("/lab");
  EXPECT_EQ(screen().back(), "sessions that contain: lab_");
  EXPECT_TRUE(view_.press(TopKey::character, 'q')) << "part of the text";
  view_.press(TopKey::erase);
  view_.press(TopKey::enter);
  const auto ids = shown();
  ASSERT_FALSE(ids.empty());
  EXPECT_TRUE(std::all_of(ids.begin(), ids.end(), [](int id) { return id % 2 == 1; }));
  EXPECT_NE(screen().back().find("of 20 that contain 'lab', 40 in all"), std::string::npos) << screen().back();
  view_.press(TopKey::escape);
  EXPECT_NE(screen().back().find("of 40 "), std::string::npos);
}

TEST_F(Top, HelpComesAndGoesAndQLeaves) {
  type("?");
  const auto helped = screen();
  EXPECT_NE(std::find(helped.begin(), helped.end(), "Keys"), helped.end());
  type("x");
  EXPECT_FALSE(shown().empty());
  EXPECT_FALSE(view_.press(TopKey::character, 'q'));
}

TEST_F(Top, FitsAnyTerminal) {
  for (const size_t rows : {1u, 2u, 5u, 10u, 100u}) {
    for (const size_t columns : {1u, 20u, 300u}) {
      const auto lines = screen(rows, columns);
      EXPECT_EQ(lines.size(), rows);
      for (const auto& line : lines) EXPECT_LE(line.size(), columns);
    }
  }
  now_["sessions"] = json::array();
  EXPECT_EQ(screen().back(), "no sessions   ? help  q leave");
}

TEST_F(Top, TroubleStandsWhereTheHeadingWas) {
  const auto lines = view_.screen(top_tables({before_, now_, 1.0}), 24, 80, "does not answer");
  EXPECT_EQ(lines.front(), "does not answer");
}

TEST(SceneLoad, SaysWhatASceneIsAtAndHowFarThatIs) {
  const auto line = [](nlohmann::json scene) {
    scene["name"] = "temple";
    return stage_line({{"scenes_under_way", {scene}}}, "temple");
  };
  EXPECT_EQ(line({{"stage", "reading"}, {"seconds", 3.2}, {"share", 0.437}}), "temple is being read, 43%, 3 s");
  EXPECT_EQ(line({{"stage", "queued"}, {"seconds", 1.0}}), "temple waits for others to be read, 1 s");
}

}  // namespace
}  // namespace gnomon::ctl
