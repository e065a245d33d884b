// The operators' page: the files of daemon/admin/page/ as text, embedded by the build.
#pragma once

namespace gnomon::daemon {

extern const char* const kPageHtml;
extern const char* const kPageCss;
extern const char* const kPageJs;

}  // namespace gnomon::daemon
