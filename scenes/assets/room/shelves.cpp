#include <cmath>

#include "scenes/assets/random.h"
#include "scenes/assets/room/props.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets::room {
namespace {

constexpr float kCaseWidth = 2.4f, kCaseHigh = 2.2f, kCaseDepth = 0.32f, kBoard = 0.028f;
constexpr int kShelves = 5, kBays = 3;

void add_box(Mesh& mesh, glm::vec3 low, glm::vec3 high, float bevel = 0.003f) {
  append(mesh, bevel_box(low, high, bevel));
}

// A standing book: boards about a block of pages set in by 3 mm, its spine towards +Z. Left edge at x = 0.
void add_book(Model& model, uint32_t cover, uint32_t pages, glm::vec3 size, const glm::mat4& placement) {
  const float t = 0.0028f;
  Mesh book;
  append(book, bevel_box({0, 0, -size.z}, {t, size.y, 0}, 0));
  append(book, bevel_box({size.x - t, 0, -size.z}, {size.x, size.y, 0}, 0));
  append(book, sheet(3, 1, t, [=](float u, float v) {  // the rounded spine
           const float x = (2 * u - 1);
           return glm::vec3((0.5f + 0.497f * x) * size.x, v * size.y * 0.998f + 0.0002f,
                            0.004f * (1 - x * x) + 0.0005f);
         }));
  append(model.in(cover), book, placement);
  append(model.in(pages),
         bevel_box({0.5f * t, 0.004f, -size.z + 0.004f}, {size.x - 0.5f * t, size.y - 0.004f, -0.0024f}, 0),
         placement);
}

// Books from `left` to `right` on a shelf: upright, now and then one leaning or a gap.
void add_row(Model& model, const Palette& palette, Random& random, float left, float right, float y, float tall) {
  float x = left;
  while (true) {
    const glm::vec3 size{random.range(0.018f, 0.050f), random.range(0.62f, 0.96f) * tall,
                         random.range(0.15f, 0.22f)};
    if (x + size.x + 0.002f > right) return;
    const float front = 0.5f * kCaseDepth - random.range(0.03f, 0.06f);
    add_book(model, palette.book[random.below(8)], palette.paper, size, at(x, y, front));
    x += size.x + 0.0015f;
  }
}

glm::vec3 shelf_origin(int bay, int shelf) {
  const float pitch = (kCaseWidth - kBoard) / kBays, rise = (kCaseHigh - 0.10f - kBoard) / kShelves;
  return {-0.5f * kCaseWidth + kBoard + pitch * static_cast<float>(bay),
          0.10f + kBoard + rise * static_cast<float>(shelf) - 0.001f, 0};
}

void add_carcass(Mesh& wood) {
  const float w = 0.5f * kCaseWidth, d = 0.5f * kCaseDepth;
  const float pitch = (kCaseWidth - kBoard) / kBays, rise = (kCaseHigh - 0.10f - kBoard) / kShelves;
  for (int i = 0; i <= kBays; ++i) {
    const float x = -w + pitch * static_cast<float>(i);
    add_box(wood, {x, 0.10f, -d + 0.002f}, {x + kBoard, kCaseHigh - 0.002f, d - 0.002f});
  }
  for (int i = 0; i <= kShelves; ++i) {
    const float y = 0.10f + rise * static_cast<float>(i);
    add_box(wood, {-w - 0.001f, y, -d + 0.001f}, {w + 0.001f, y + kBoard, i == kShelves ? d + 0.01f : d - 0.006f});
  }
  add_box(wood, {-w + 0.004f, 0.104f, -d}, {w - 0.004f, kCaseHigh - 0.004f, -d + 0.012f});
  add_box(wood, {-w + 0.03f, -0.002f, -d + 0.03f}, {w - 0.03f, 0.104f, d - 0.03f});
}

}  // namespace

Model bookcase(const Palette& palette) {
  Random random(71);
  Model model{"bookcase", {}};
  add_carcass(model.in(palette.walnut));
  const float pitch = (kCaseWidth - kBoard) / kBays - kBoard;
  // The share of each bay's width that books fill; the rest is free for ornaments.
  const float filled[kShelves][kBays] = {
      {1, 0.55f, 1}, {0.45f, 1, 0.8f}, {1, 0.35f, 0.6f}, {0.6f, 1, 0}, {0.8f, 0.5f, 0.9f}};
  for (int shelf = 0; shelf < kShelves; ++shelf) {
    for (int bay = 0; bay < kBays; ++bay) {
      const glm::vec3 o = shelf_origin(bay, shelf);
      add_row(model, palette, random, o.x + 0.006f, o.x + pitch * filled[shelf][bay] - 0.006f, o.y, 0.34f);
    }
  }
  const auto ornament = [&](const Model& thing, int bay, int shelf, float share, float scale) {
    const glm::mat4 placement = at(shelf_origin(bay, shelf) + glm::vec3(share * pitch, 0, 0.02f)) * scaled(scale);
    for (const Part& part : thing.parts) append(model.in(part.material), part.mesh, placement);
  };
  ornament(vase(0, palette.terracotta), 1, 0, 0.78f, 1.1f);
  ornament(vase(2, palette.porcelain), 0, 1, 0.68f, 1.2f);
  ornament(book_pile(palette, 77), 1, 2, 0.68f, 0.8f);
  ornament(teapot(palette), 2, 2, 0.80f, 1.0f);
  ornament(vase(1, palette.stoneware), 2, 3, 0.2f, 1.0f);
  ornament(vase(0, palette.glass_green), 2, 3, 0.5f, 1.15f);
  ornament(vase(2, palette.mustard), 2, 3, 0.8f, 1.1f);
  ornament(vase(2, palette.brass), 0, 3, 0.82f, 1.0f);
  ornament(fruit_bowl(palette), 1, 4, 0.77f, 0.9f);
  return model;
}

Model book_pile(const Palette& palette, uint32_t seed) {
  Random random(seed);
  Model model{"book pile", {}};
  float y = 0.0005f;
  for (int i = 0; i < 4; ++i) {
    const glm::vec3 size{random.range(0.02f, 0.04f), random.range(0.24f, 0.30f), random.range(0.17f, 0.21f)};
    const glm::mat4 lying =
        turned(random.range(-14.0f, 14.0f)) * at(0.5f * size.y, y, 0.5f * size.z) * turned(90, {0, 0, 1});
    add_book(model, palette.book[random.below(8)], palette.paper, size, lying);
    y += size.x + 0.0008f;
  }
  return model;
}

Model record_player(const Palette& palette) {
  Model model{"record player", {}};
  append(model.in(palette.walnut), rounded_box({0.44f, 0.09f, 0.34f}, 0.012f, 3), at(0, 0.06f, 0));
  for (const float x : {-0.18f, 0.18f}) {
    for (const float z : {-0.13f, 0.13f})
      append(model.in(palette.black_metal), cylinder(0.018f, 0.0f, 0.02f, 16, 0.003f), at(x, 0, z));
  }
  // The record's grooves are real rings.
  std::vector<glm::vec2> grooves{{0, 0.106f}, {0.152f, 0.106f}, {0.154f, 0.112f}};
  for (int i = 0; i < 14; ++i) {
    const float r = 0.148f - 0.006f * static_cast<float>(i);
    grooves.emplace_back(r, 0.1135f), grooves.emplace_back(r - 0.003f, 0.1125f);
  }
  grooves.emplace_back(0, 0.1127f);
  append(model.in(palette.black_metal), lathe(grooves, 40), at(-0.05f, 0, 0));
  append(model.in(palette.rose), cylinder(0.05f, 0.112f, 0.1142f, 40, 0.0004f), at(-0.05f, 0, 0));
  append(model.in(palette.chrome), cylinder(0.0035f, 0.112f, 0.124f, 10, 0.001f), at(-0.05f, 0, 0));
  append(model.in(palette.chrome), cylinder(0.020f, 0.10f, 0.135f, 20, 0.003f), at(0.165f, 0, -0.11f));
  append(model.in(palette.chrome), tube(curve(std::vector<glm::vec3>{{0.165f, 0.14f, -0.11f},
                                                                     {0.165f, 0.142f, 0.02f},
                                                                     {0.14f, 0.138f, 0.08f},
                                                                     {0.075f, 0.122f, 0.105f}},
                                              6),
                                        0.005f, 10));
  append(model.in(palette.chrome), cylinder(0.014f, 0.10f, 0.118f, 16, 0.003f), at(0.175f, 0, 0.125f));
  return model;
}

}  // namespace gnomon::scenes::assets::room
