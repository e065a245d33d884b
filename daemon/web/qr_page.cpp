#include "daemon/web/qr_page.h"

#include <qrencode.h>

#include "daemon/web/percent_encoding.h"

namespace gnomon::daemon::web {
namespace {

constexpr std::string_view kFolder = "/qr/", kSuffix = ".svg";
constexpr size_t kMostBytes = 512;  // of the address
constexpr int kQuiet = 4;           // modules around the symbol, by the standard

struct FreeCode {
  void operator()(QRcode* code) const { QRcode_free(code); }
};

// One path: a unit square for each dark module.
std::string svg_of(const QRcode& code) {
  const std::string side = std::to_string(code.width + 2 * kQuiet);
  std::string svg;
  svg.append("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 ").append(side).append(" ").append(side);
  svg.append("\"><path fill=\"#fff\" d=\"M0 0h").append(side).append("v").append(side).append("H0z\"/><path d=\"");
  for (int y = 0; y < code.width; ++y)
    for (int x = 0; x < code.width; ++x)
      if (code.data[y * code.width + x] & 1) {
        svg.append("M").append(std::to_string(x + kQuiet)).append(" ").append(std::to_string(y + kQuiet));
        svg.append("h1v1h-1z");
      }
  return svg.append("\"/></svg>");
}

}  // namespace

std::optional<std::string> qr_target(std::string_view target) {
  if (!target.starts_with(kFolder) || !target.ends_with(kSuffix)) return std::nullopt;
  target.remove_prefix(kFolder.size());
  if (target.size() < kSuffix.size()) return std::nullopt;
  target.remove_suffix(kSuffix.size());
  return percent_decoded(target);
}

Response qr_page(const Request& request, const std::string& fragment) {
  const std::string address = "https://" + request.host + "/#" + fragment;
  if (address.size() > kMostBytes) return text_response(400, "the address is too long for a code");
  const std::unique_ptr<QRcode, FreeCode> code(QRcode_encodeData(
      static_cast<int>(address.size()), reinterpret_cast<const unsigned char*>(address.data()), 0, QR_ECLEVEL_M));
  if (!code) return text_response(400, "the address cannot be written as a code");
  const std::string svg = svg_of(*code);
  return {.fields = {{"Content-Type", "image/svg+xml"}, {"Cache-Control", "no-store"}},
          .body = std::make_shared<const std::vector<uint8_t>>(svg.begin(), svg.end())};
}

}  // namespace gnomon::daemon::web
