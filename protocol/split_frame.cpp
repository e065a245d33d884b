#include "protocol/split_frame.h"

#include <cassert>
#include <utility>

#include "protocol/band_encoder.h"

namespace gnomon::protocol {

SplitFrame SplitFrame::of_context(const PackedMaskView& frame, size_t max_payload_bytes, MaskReferencePtr reference,
                                  const std::optional<CameraView>& camera) {
  assert(max_payload_bytes >= kMinPayloadBytes);
  SplitFrame split(CodecId::tiles_context, max_payload_bytes);
  split.reference_ = std::move(reference);
  split.tiles_.take(frame);
  split.tiles_.refer_to(split.reference_.get(), camera);
  split.units_ = context::plan_units(split.tiles_, max_payload_bytes);
  split.encoded_.resize(split.units_.size());
  return split;
}

SplitFrame SplitFrame::of_bands(const PackedMaskView& frame, size_t max_payload_bytes) {
  assert(max_payload_bytes >= kMinPayloadBytes);
  SplitFrame split(CodecId::tiles_lz4, max_payload_bytes);
  split.mask_ = frame;
  split.bands_.plan(frame);
  split.encoded_.resize(split.bands_.band_count());
  return split;
}

void SplitFrame::encode(size_t unit) {
  EncodedMask& out = encoded_[unit];
  out.begin(codec_);
  if (codec_ == CodecId::tiles_context) {
    static thread_local context::UnitEncoder encoder;
    encoder.encode(tiles_, units_[unit], limit_, out);
  } else {
    static thread_local BandEncoder encoder;
    encoder.encode(mask_, bands_, unit, limit_, out);
  }
}

Result<void> SplitFrame::join(EncodedMask& out) {
  out.begin(codec_);
  for (const EncodedMask& part : encoded_) {
    const size_t first = out.bytes.size();
    out.slices.insert(out.slices.end(), part.slices.begin(), part.slices.end());
    out.bytes.insert(out.bytes.end(), part.bytes.begin(), part.bytes.end());
    for (size_t i = 1; i < part.offsets.size(); ++i) out.offsets.push_back(first + part.offsets[i]);
  }
  return out.number_slices();
}

}  // namespace gnomon::protocol
