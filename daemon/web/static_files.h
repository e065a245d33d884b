// The browser client's own files: embedded by the build, made what browsers get at the start (page_source.h) and compressed,
// constant from then on. Any thread.
#pragma once

#include <map>
#include <span>
#include <string>

#include "common/result.h"
#include "daemon/web/web_response.h"

namespace gnomon::daemon::web {

// A file below web/, as the build embeds it.
struct EmbeddedFile {
  const char* path;  // "/render/renderer.js"; "/" is index.html
  std::span<const uint8_t> bytes;
};
std::span<const EmbeddedFile> embedded_files();

class StaticFiles {
 public:
  // `fleet`: of which the server is; if empty, of none.
  static StaticFiles of(std::span<const EmbeddedFile> files, const std::string& fleet = {});

  // The answer to a GET or HEAD; 404 if there is no such file. Browsers ask each time whether a file has changed, as a
  // daemon that was replaced has others.
  Response answer(const Request& request) const;

 private:
  struct File {
    const char* type = "";
    std::string etag;
    SharedBytes plain, brotli;  // brotli is nullptr if it is no shorter
    std::string script = {};    // as in Response
  };
  std::map<std::string, File, std::less<>> files_;
};

}  // namespace gnomon::daemon::web
