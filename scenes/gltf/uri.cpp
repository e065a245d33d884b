#include "scenes/gltf/uri.h"

#include "scenes/gltf/model.h"

namespace gnomon::scenes::gltf {
namespace {

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

std::string percent_decoded(const std::string& text) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool escape = text[i] == '%' && i + 2 < text.size();
    const int high = escape ? hex_value(text[i + 1]) : -1;
    const int low = escape ? hex_value(text[i + 2]) : -1;
    if (high >= 0 && low >= 0) {
      out += static_cast<char>(high * 16 + low);
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

bool is_data_uri(const std::string& uri) { return uri.rfind("data:", 0) == 0; }

Result<std::vector<uint8_t>> decode_data_uri(const std::string& uri) {
  const size_t comma = uri.find(',');
  if (comma == std::string::npos) return Error{"a data URI without data"};
  const std::string kBase64 = ";base64";
  const bool base64 = comma >= kBase64.size() && uri.compare(comma - kBase64.size(), kBase64.size(), kBase64) == 0;
  if (!base64) {
    const std::string text = percent_decoded(uri.substr(comma + 1));
    return std::vector<uint8_t>(text.begin(), text.end());
  }
  // tinygltf's decoder accepts a few media types only; the bytes do not depend on the type.
  std::vector<uint8_t> bytes;
  std::string media_type;
  if (!tinygltf::DecodeDataURI(&bytes, media_type, "data:application/octet-stream;base64," + uri.substr(comma + 1),
                               0, false)) {
    return Error{"a data URI whose base64 cannot be read"};
  }
  return bytes;
}

}  // namespace gnomon::scenes::gltf
