#include <gtest/gtest.h>

#include "daemon/web/percent_encoding.h"
#include "daemon/web/qr_page.h"
#include "daemon/web/scene_pages.h"

namespace gnomon::daemon::web {
namespace {

std::string body_of(const Response& response) { return {response.body->begin(), response.body->end()}; }

TEST(Addresses, EveryByteComesBackFromItsEncoding) {
  std::string all;
  for (int code = 0; code < 256; ++code) all += static_cast<char>(code);
  EXPECT_EQ(percent_decoded(percent_encoded(all)), all);
  EXPECT_EQ(percent_encoded("a b/\xc3\xa9"), "a%20b/%C3%A9");
}

TEST(Addresses, WhatIsNoEscapeStays) {
  for (const char* text : {"%", "%4", "%zz", "100%", "%%41"}) {
    EXPECT_EQ(percent_decoded(text), std::string(text) == "%%41" ? "%A" : text);
  }
}

TEST(Addresses, ACodeIsOfThisServersPage) {
  EXPECT_EQ(qr_target("/qr/scene%3Dtemple%26cam%3D1%2C2.svg"), "scene=temple&cam=1,2");
  EXPECT_EQ(qr_target("/qr/.svg"), "");
  EXPECT_FALSE(qr_target("/qr/scene=temple"));
  EXPECT_FALSE(qr_target("/icon.svg"));
  Request request;
  request.host = "node.example:7600";
  const Response response = qr_page(request, "scene=temple");
  EXPECT_EQ(response.status, 200);
  const std::string svg = body_of(response);
  EXPECT_TRUE(svg.starts_with("<svg ") && svg.ends_with("</svg>"));
  EXPECT_EQ(svg.find("temple"), svg.npos);  // it is drawn, not written
  EXPECT_NE(body_of(qr_page(request, "scene=tempel")), svg);
}

TEST(Addresses, AnAddressThatIsTooLongForACodeIsRefused) {
  Request request;
  request.host = "node.example";
  EXPECT_EQ(qr_page(request, std::string(400, 'x')).status, 200);
  EXPECT_EQ(qr_page(request, std::string(600, 'x')).status, 400);
}

TEST(Addresses, TheListOfScenesHasAnAddress) {
  EXPECT_EQ(scene_target("/scene/")->name, "");
  EXPECT_EQ(body_of(scene_list({"a", "b\"c"})), R"({"scenes":["a","b\"c"]})");
}

}  // namespace
}  // namespace gnomon::daemon::web
