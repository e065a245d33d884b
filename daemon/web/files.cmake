# Writes a source with the bytes of the browser client's files: cmake -DOUT=... "-DFILES=PATH=FILE;..." -P files.cmake
set(text "#include \"daemon/web/static_files.h\"\n\nnamespace gnomon::daemon::web {\nnamespace {\n\n")
set(table "")
set(number 0)
foreach(entry IN LISTS FILES)
  string(REGEX MATCH "^([^=]+)=(.+)$" matched "${entry}")
  set(path ${CMAKE_MATCH_1})
  file(READ ${CMAKE_MATCH_2} hex HEX)
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${hex}")
  # A file may be empty, an array may not: one zero follows each.
  string(APPEND text "constexpr uint8_t kFile${number}[] = {${bytes}0};\n")
  string(APPEND table "    {\"${path}\", std::span(kFile${number}).first(sizeof kFile${number} - 1)},\n")
  math(EXPR number "${number} + 1")
endforeach()
string(APPEND text "\nconst EmbeddedFile kFiles[] = {\n${table}};\n\n}  // namespace\n\n"
  "std::span<const EmbeddedFile> embedded_files() { return kFiles; }\n\n}  // namespace gnomon::daemon::web\n")
file(WRITE ${OUT} "${text}")
