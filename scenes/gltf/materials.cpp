#include "scenes/gltf/materials.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "common/log.h"
#include "scenes/gltf/image.h"

namespace gnomon::scenes::gltf {
namespace {

Wrap wrap_of(int code) {
  if (code == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return Wrap::clamp_to_edge;
  if (code == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return Wrap::mirrored_repeat;
  return Wrap::repeat;
}

// What is made of an image's file. Neither: nobody asks for it.
struct Wanted {
  bool texels = false;
  bool encoded = false;
};

// What a material needs of its base colour texture.
Wanted wanted_by(const Material& material, Reads reads) {
  return {reads == Reads::colours || material.alpha_mode == AlphaMode::mask, reads == Reads::encoded};
}

Result<void> decode_into(std::span<const uint8_t> bytes, const ImageHeader& header, Texture& texture) {
  Result<Image> image = decode_image(bytes, header);
  if (!image) return image.error();
  texture.rgba = std::move(image->rgba);
  for (size_t i = 3; i < texture.rgba.size(); i += 4) texture.has_alpha |= texture.rgba[i] != 255;
  return {};
}

// `name`: of the image, for errors. The same bytes may be named by many images, and are read for each. An image that is
// only passed on takes of the budget what it takes of whoever decodes it.
Result<Texture> texture_of(std::span<const uint8_t> bytes, Wanted wanted, Budget& budget, const std::string& name) {
  const auto header = read_image_header(bytes);
  if (!header) return Error{name + " " + header.error().message};
  const std::string size = std::to_string(header->width) + " x " + std::to_string(header->height);
  auto granted = budget.decode(header->width, header->height, header->scans);
  if (granted) granted = budget.spend(bytes.size(), wanted.encoded ? 2 : 1);
  if (!granted) return Error{name + " of " + size + " " + granted.error().message};
  Texture texture;
  texture.width = header->width;
  texture.height = header->height;
  if (wanted.encoded) texture.encoded.assign(bytes.begin(), bytes.end());
  if (!wanted.texels) return texture;
  if (const auto decoded = decode_into(bytes, *header, texture); !decoded) {
    return Error{name + " " + decoded.error().message};
  }
  return texture;
}

Result<Texture> read_image(Document& document, int index, Wanted wanted) {
  const auto source = entry(document.images, index, "image");
  if (!source) return source.error();
  const std::string name = "image " + std::to_string(index);
  if ((*source)->buffer_view >= 0) {
    const auto bytes = document.view((*source)->buffer_view);
    if (!bytes) return Error{name + ": " + bytes.error().message};
    return texture_of(*bytes, wanted, document.budget, name);
  }
  const auto bytes = read_uri(document.folder, (*source)->uri, document.budget);
  if (!bytes) return Error{name + ": " + bytes.error().message};
  return texture_of(*bytes, wanted, document.budget, name);
}

// Reads each texture once, however many materials use it. An image that cannot be read is tried once, however many
// textures use it.
class Textures {
 public:
  explicit Textures(Document& document) : document_(document) {}

  // Index into Scene::textures.
  Result<uint32_t> get(int texture, Wanted wanted) {
    if (const auto known = known_.find(texture); known != known_.end()) {
      return known->second && wanted.texels ? with_texels(*known->second) : known->second;
    }
    Result<Texture> made = read(texture, wanted);
    if (!made && !document_.budget.exceeded()) {
      log::warning("texture left out", {{"texture", texture}, {"why", made.error().message}});
    }
    Result<uint32_t> index = made ? Result<uint32_t>(static_cast<uint32_t>(textures_.size())) : made.error();
    if (made) textures_.push_back(std::move(*made));
    known_.emplace(texture, index);
    return index;
  }

  std::vector<Texture> take() { return std::move(textures_); }

 private:
  // A texture that was kept as a file gets its texels, because a later material tests its alpha.
  Result<uint32_t> with_texels(uint32_t index) {
    Texture& texture = textures_[index];
    if (!texture.rgba.empty()) return index;
    const auto header = read_image_header(texture.encoded);
    if (!header) return header.error();
    if (const auto decoded = decode_into(texture.encoded, *header, texture); !decoded) return decoded.error();
    return index;
  }

  Result<Texture> read(int index, Wanted wanted) {
    const auto found = entry(document_.model.textures, index, "texture");
    if (!found) return found.error();
    const int source = (*found)->source;
    if (const auto broken = broken_images_.find(source); broken != broken_images_.end()) return broken->second;
    Result<Texture> texture = read_image(document_, source, wanted);
    if (!texture) {
      broken_images_.emplace(source, texture.error());
      return texture.error();
    }
    if ((*found)->sampler >= 0) {
      const auto sampler = entry(document_.model.samplers, (*found)->sampler, "sampler");
      if (!sampler) return sampler.error();
      texture->wrap_u = wrap_of((*sampler)->wrapS);
      texture->wrap_v = wrap_of((*sampler)->wrapT);
    }
    return texture;
  }

  Document& document_;
  std::vector<Texture> textures_;
  std::map<int, Result<uint32_t>> known_;  // by texture of the file
  std::map<int, Error> broken_images_;
};

double number(const tinygltf::Value& object, const char* key, double otherwise) {
  return object.Has(key) && object.Get(key).IsNumber() ? object.Get(key).GetNumberAsDouble() : otherwise;
}

glm::vec2 pair(const tinygltf::Value& object, const char* key, const glm::vec2& otherwise) {
  if (!object.Has(key)) return otherwise;
  const tinygltf::Value& array = object.Get(key);
  if (!array.IsArray() || array.ArrayLen() != 2 || !array.Get(0).IsNumber() || !array.Get(1).IsNumber()) {
    return otherwise;
  }
  return {array.Get(0).GetNumberAsDouble(), array.Get(1).GetNumberAsDouble()};
}

TextureCoordinates coordinates_of(const tinygltf::TextureInfo& info) {
  TextureCoordinates coordinates;
  coordinates.set = info.texCoord;
  const auto extension = info.extensions.find("KHR_texture_transform");
  if (extension == info.extensions.end()) return coordinates;
  const tinygltf::Value& t = extension->second;
  const glm::vec2 offset = pair(t, "offset", glm::vec2(0.0f));
  const glm::vec2 scale = pair(t, "scale", glm::vec2(1.0f));
  const auto angle = static_cast<float>(number(t, "rotation", 0.0));
  if (t.Has("texCoord") && t.Get("texCoord").IsInt()) coordinates.set = t.Get("texCoord").GetNumberAsInt();
  const float c = std::cos(angle);
  const float s = std::sin(angle);
  // Translation x rotation x scale, in columns, as the specification of KHR_texture_transform defines it.
  coordinates.transform = glm::mat3(c * scale.x, -s * scale.x, 0.0f,  //
                                    s * scale.y, c * scale.y, 0.0f,   //
                                    offset.x, offset.y, 1.0f);
  return coordinates;
}

AlphaMode alpha_mode_of(const std::string& name) {
  if (name == "MASK") return AlphaMode::mask;
  if (name == "BLEND") return AlphaMode::blend;
  return AlphaMode::opaque;
}

float emissive_strength(const tinygltf::Material& source) {
  const auto extension = source.extensions.find("KHR_materials_emissive_strength");
  if (extension == source.extensions.end()) return 1.0f;
  return static_cast<float>(number(extension->second, "emissiveStrength", 1.0));
}

Material factors_of(const tinygltf::Material& source) {
  Material material;
  material.name = source.name;
  const auto& base = source.pbrMetallicRoughness.baseColorFactor;
  for (int i = 0; i < 4 && base.size() == 4; ++i)
    material.base_color[i] = static_cast<float>(base[static_cast<size_t>(i)]);
  for (int i = 0; i < 3 && source.emissiveFactor.size() == 3; ++i) {
    material.emissive[i] = static_cast<float>(source.emissiveFactor[static_cast<size_t>(i)]);
  }
  material.emissive *= emissive_strength(source);
  material.alpha_mode = alpha_mode_of(source.alphaMode);
  material.alpha_cutoff = static_cast<float>(source.alphaCutoff);
  material.double_sided = source.doubleSided;
  return material;
}

bool all_finite(const Material& m) {
  const float numbers[] = {m.base_color.r, m.base_color.g, m.base_color.b, m.base_color.a,
                           m.emissive.r,   m.emissive.g,   m.emissive.b,   m.alpha_cutoff};
  return std::all_of(std::begin(numbers), std::end(numbers), [](float v) { return std::isfinite(v); });
}

// Whether the texture names an image. It may leave that to an extension that is not supported; then it is treated as
// absent.
bool has_source(const Document& document, int texture) {
  const auto found = entry(document.model.textures, texture, "texture");
  return !found || (*found)->source != -1;
}

}  // namespace

Result<Materials> read_materials(Document& document, Reads reads) {
  Materials out;
  Textures textures(document);
  for (const tinygltf::Material& source : document.model.materials) {
    const std::string name = "material " + std::to_string(out.materials.size()) + " '" + source.name + "'";
    Material material = factors_of(source);
    if (!all_finite(material)) return Error{name + " has a number that is not finite"};
    const tinygltf::TextureInfo& info = source.pbrMetallicRoughness.baseColorTexture;
    const Wanted wanted = wanted_by(material, reads);
    if ((wanted.texels || wanted.encoded) && info.index != -1 && has_source(document, info.index)) {
      const Result<uint32_t> texture = textures.get(info.index, wanted);
      if (!texture && material.alpha_mode == AlphaMode::mask) {
        return Error{name + " needs its texture for an alpha test: " + texture.error().message};
      }
      if (!texture && document.budget.exceeded()) return Error{name + ": " + texture.error().message};
      if (texture) material.base_color_texture = *texture;
    }
    out.materials.push_back(std::move(material));
    out.coordinates.push_back(coordinates_of(info));
  }
  out.default_material = static_cast<uint32_t>(out.materials.size());
  out.materials.emplace_back();
  out.coordinates.emplace_back();
  out.textures = textures.take();
  return out;
}

}  // namespace gnomon::scenes::gltf
