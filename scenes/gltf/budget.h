// What reading one file may cost, measured by what the file itself holds. Internal to scenes/gltf/.
//
// glTF lets few bytes stand for much: a picture unpacks, an accessor without bytes is zeros, and one accessor may be
// named by every mesh. Whatever is made of the file is therefore announced here before memory is taken for it.
#pragma once

#include <cstdint>

#include "common/result.h"
#include "scenes/loader.h"

namespace gnomon::scenes::gltf {

class Budget {
 public:
  explicit Budget(const LoadLimits& limits);

  // `bytes` of the file, or of one that it names, are about to be read for the first time. Error: the files are too
  // large together.
  Result<void> read(uint64_t bytes);

  // `count` things of `each` bytes are about to be made. Error: that is more than files of this size may take.
  Result<void> spend(uint64_t count, uint64_t each = 1);

  // An image is about to be decoded. Error: it is too large, or has more scans than an encoder would write.
  Result<void> decode(uint32_t width, uint32_t height, uint32_t scans);

  // Whether anything was refused. Then the whole file is, also where it could do without the part.
  bool exceeded() const { return exceeded_; }

 private:
  LoadLimits limits_;
  uint64_t read_bytes_ = 0;
  uint64_t spent_bytes_ = 0;
  uint64_t texels_ = 0;
  bool exceeded_ = false;
};

}  // namespace gnomon::scenes::gltf
