#include "daemon/quic/qpack.h"

#include <nghttp3/nghttp3.h>

#include <memory>
#include <new>

namespace gnomon::daemon::quic {
namespace {

std::string text_of(nghttp3_rcbuf* buffer) {
  const nghttp3_vec bytes = nghttp3_rcbuf_get_buf(buffer);
  return {reinterpret_cast<const char*>(bytes.base), bytes.len};
}

struct Decoder {
  nghttp3_qpack_decoder* decoder = nullptr;
  nghttp3_qpack_stream_context* stream = nullptr;

  Decoder() {
    if (nghttp3_qpack_decoder_new(&decoder, 0, 0, nghttp3_mem_default()) != 0 ||
        nghttp3_qpack_stream_context_new(&stream, 0, nghttp3_mem_default()) != 0) {
      nghttp3_qpack_decoder_del(decoder);
      throw std::bad_alloc();
    }
  }
  ~Decoder() {
    nghttp3_qpack_stream_context_del(stream);
    nghttp3_qpack_decoder_del(decoder);
  }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;
};

const uint8_t* bytes_of(const std::string& text) { return reinterpret_cast<const uint8_t*>(text.data()); }

}  // namespace

std::optional<Fields> decode_fields(std::span<const uint8_t> section) {
  const Decoder decoder;
  Fields fields;
  for (size_t count = 0;;) {
    nghttp3_qpack_nv field{};
    uint8_t flags = NGHTTP3_QPACK_DECODE_FLAG_NONE;
    const nghttp3_ssize taken = nghttp3_qpack_decoder_read_request(decoder.decoder, decoder.stream, &field, &flags,
                                                                   section.data(), section.size(), 1);
    if (taken < 0 || (flags & NGHTTP3_QPACK_DECODE_FLAG_BLOCKED) != 0) return std::nullopt;
    section = section.subspan(static_cast<size_t>(taken));
    if ((flags & NGHTTP3_QPACK_DECODE_FLAG_EMIT) != 0) {
      const std::string name = text_of(field.name), value = text_of(field.value);
      nghttp3_rcbuf_decref(field.name);
      nghttp3_rcbuf_decref(field.value);
      if (++count > kMostFields || name.size() + value.size() > kLongestField) return std::nullopt;
      fields.emplace(name, value);
    }
    if ((flags & NGHTTP3_QPACK_DECODE_FLAG_FINAL) != 0) return fields;
    if (taken == 0 && (flags & NGHTTP3_QPACK_DECODE_FLAG_EMIT) == 0) return std::nullopt;
  }
}

std::vector<uint8_t> encode_fields(const std::vector<std::pair<std::string, std::string>>& fields) {
  nghttp3_qpack_encoder* encoder = nullptr;
  if (nghttp3_qpack_encoder_new(&encoder, 0, nghttp3_mem_default()) != 0) throw std::bad_alloc();
  std::vector<nghttp3_nv> list;
  for (const auto& [name, value] : fields) {
    list.push_back({bytes_of(name), bytes_of(value), name.size(), value.size(), NGHTTP3_NV_FLAG_NONE});
  }
  nghttp3_buf prefix, section, instructions;
  for (nghttp3_buf* buffer : {&prefix, &section, &instructions}) nghttp3_buf_init(buffer);
  const int failed =
      nghttp3_qpack_encoder_encode(encoder, &prefix, &section, &instructions, 0, list.data(), list.size());
  std::vector<uint8_t> out(prefix.pos, prefix.last);
  out.insert(out.end(), section.pos, section.last);
  for (nghttp3_buf* buffer : {&prefix, &section, &instructions}) nghttp3_buf_free(buffer, nghttp3_mem_default());
  nghttp3_qpack_encoder_del(encoder);
  if (failed != 0) throw std::bad_alloc();  // memory is all that it can fail of
  return out;
}

}  // namespace gnomon::daemon::quic
