#include <cmath>

#include "scenes/assets/random.h"
#include "scenes/assets/shapes.h"
#include "scenes/assets/temple/props.h"

namespace gnomon::scenes::assets::temple {
namespace {

constexpr float kWallHigh = kColumnHeight + kBeam;
constexpr float kCourse = 0.604f;  // twelve courses to the top of the walls
constexpr float kJoint = 0.008f;
constexpr int kCourses = 12;

void add_box(Mesh& mesh, glm::vec3 low, glm::vec3 high, float bevel = 0.012f) {
  append(mesh, bevel_box(low, high, bevel));
}

struct Opening {
  float left, right, low, high;
};

// A wall in the plane z = 0, its face towards +Z, of bevelled blocks in bond from x = 0 to `length`, with a core
// behind the joints. Blocks that meet an opening are cut at it.
Model block_wall(const Palette& palette, float length, const std::vector<Opening>& openings, uint32_t seed) {
  Random random(seed);
  Model model{"wall", {}};
  for (int course = 0; course < kCourses; ++course) {
    const float low = kCourse * static_cast<float>(course), high = low + kCourse - kJoint;
    float x = 0;
    while (x < length - 0.01f) {
      float width = random.range(0.85f, 1.5f);
      if (length - x - width < 0.5f) width = length - x;
      float left = x, right = x + width - kJoint;
      x += width;
      bool open = false;
      for (const Opening& o : openings) {
        if (high < o.low + 0.01f || low > o.high - 0.01f) continue;
        if (left >= o.left - 0.01f && right <= o.right + 0.01f)
          open = true;
        else if (left < o.left && right > o.right) {  // a wide block about a narrow opening: its right half
          add_box(model.in(palette.block[random.below(3)]), {o.right, low, -0.5f}, {right, high, 0}, 0.018f);
          right = o.left;
        } else if (left < o.left && right > o.left)
          right = o.left;
        else if (left < o.right && right > o.right)
          left = o.right;
      }
      if (open || right - left < 0.05f) continue;
      add_box(model.in(palette.block[random.below(3)]), {left, low, -0.5f},
              {right, high, random.range(-0.012f, 0.004f)}, 0.018f);
    }
  }
  // The core: strips between the openings, a little behind the face.
  float from = 0.002f;
  const auto core = [&](float left, float right, float low, float high) {
    if (right - left > 0.02f && high - low > 0.02f)
      add_box(model.in(palette.joint), {left, low, -0.47f}, {right, high, -0.03f}, 0);
  };
  for (const Opening& o : openings) {
    core(from, o.left - 0.004f, 0.001f, kWallHigh - 0.01f);
    core(o.left - 0.004f, o.right + 0.004f, 0.001f, o.low - 0.004f);
    core(o.left - 0.004f, o.right + 0.004f, o.high + 0.004f, kWallHigh - 0.01f);
    from = o.right + 0.004f;
  }
  core(from, length - 0.002f, 0.001f, kWallHigh - 0.01f);
  return model;
}

// Flagstones in rows across, each set a little differently.
Model paving(const Palette& palette, float left, float right, float far_z, float near_z, uint32_t seed) {
  Random random(seed);
  Model model{"paving", {}};
  const int rows = static_cast<int>(std::lround((near_z - far_z) / 1.0f));
  const float deep = (near_z - far_z) / static_cast<float>(rows);
  for (int row = 0; row < rows; ++row) {
    const float z = far_z + deep * static_cast<float>(row);
    for (float x = left; x < right - 0.01f;) {
      float width = random.range(0.8f, 1.35f);
      if (right - x - width < 0.6f) width = right - x;
      const float top = random.range(-0.006f, 0.0f);
      add_box(model.in(palette.paving[random.below(3)]), {x + 0.004f, -0.15f, z + 0.004f},
              {x + width - 0.004f, top, z + deep - 0.004f}, 0.010f);
      x += width;
    }
  }
  add_box(model.in(palette.joint), {left - 0.2f, -0.35f, far_z - 0.2f}, {right + 0.2f, -0.02f, near_z + 0.2f}, 0);
  return model;
}

// A square coffer seen from below: two steps up to a panel with a gilded rosette.
Model coffer(const Palette& palette, float size) {
  Model model{"coffer", {}};
  Mesh& stone = model.in(palette.sandstone);
  float half = 0.5f * size, low = 0.0f;
  const float width[] = {0.18f, 0.16f}, rise[] = {0.18f, 0.16f};
  for (int i = 0; i < 2; ++i) {
    const float inner = half - width[i], top = 0.5f;
    add_box(stone, {-half, low, -half}, {half, top, -inner}, 0);
    add_box(stone, {-half, low, inner}, {half, top, half}, 0);
    add_box(stone, {-half, low + 0.002f, -inner - 0.01f}, {-inner, top - 0.002f, inner + 0.01f}, 0);
    add_box(stone, {inner, low + 0.002f, -inner - 0.01f}, {half, top - 0.002f, inner + 0.01f}, 0);
    half = inner + 0.01f, low += rise[i];
  }
  add_box(model.in(palette.blue_band), {-half, low, -half}, {half, 0.49f, half}, 0);
  Mesh rosette = sphere(0.07f, 8);
  for (int i = 0; i < 6; ++i) {
    append(rosette,
           barrel(6, 3,
                  [](float u, float v) {
                    const float a = 6.2831853f * u, w = 0.075f * std::sin(2.9f * v + 0.15f);
                    return glm::vec3(w * std::cos(a), 0.04f + 0.22f * v, -0.4f * w * std::sin(a));
                  }),
           turned(60.0f * static_cast<float>(i), {0, 0, 1}));
  }
  append(model.in(palette.gold), rosette, at(0, low, 0) * turned(90, {1, 0, 0}));
  return model;
}

}  // namespace

void add_ground(Stage& stage, const Palette& palette) {
  stage.place(paving(palette, -kHalfWidth, kHalfWidth, kDaisFront - 0.1f, 0.4f, 5));
  Model dais{"dais", {}};
  constexpr int kSteps = 5;
  const float rise = kDais / kSteps, tread = 0.36f;
  for (int i = 0; i < kSteps; ++i) {
    const float top = rise * static_cast<float>(i + 1),
                front = kDaisFront + tread * static_cast<float>(kSteps - 1 - i);
    const float wide = 3.0f + 0.05f * static_cast<float>(kSteps - i);
    for (int k = 0; k < 4; ++k) {  // each step in four stones
      const float left = -wide + 0.5f * wide * static_cast<float>(k);
      add_box(dais.in(palette.limestone), {left + 0.003f, -0.1f, front - 0.6f},
              {left + 0.5f * wide - 0.003f, top - 0.002f, front}, 0.018f);
    }
  }
  add_box(dais.in(palette.sandstone), {-kHalfWidth - 0.1f, -0.1f, -kLength - 0.3f},
          {kHalfWidth + 0.1f, kDais - 0.03f, kDaisFront - 0.05f});
  for (const float side : {-1.0f, 1.0f}) {  // cheeks of the stairs and the platform's front, with a red band
    const float a = side * 3.3f, b = side * 4.1f;
    add_box(dais.in(palette.limestone), {std::min(a, b), -0.1f, kDaisFront - 0.2f},
            {std::max(a, b), kDais + 0.12f, kDaisFront + 1.95f}, 0.03f);
    const float c = side * 4.1f, d = side * (kHalfWidth + 0.1f);
    add_box(dais.in(palette.red_band), {std::min(c, d), 0.30f, kDaisFront - 0.1f},
            {std::max(c, d), 0.60f, kDaisFront - 0.01f});
    add_box(dais.in(palette.limestone), {std::min(c, d), kDais - 0.14f, kDaisFront - 0.3f},
            {std::max(c, d), kDais + 0.001f, kDaisFront + 0.06f}, 0.02f);
  }
  stage.place(std::move(dais));
  stage.place(paving(palette, -kHalfWidth, kHalfWidth, -kLength, kDaisFront - 0.6f, 6), at(0, kDais - 0.001f, 0));
}

void add_walls(Stage& stage, const Palette& palette) {
  // Side walls with tall windows between every other pair of columns; those of the eastern wall are mirrored.
  std::vector<Opening> windows;
  for (int i = 0; i + 1 < kColumns; ++i) {
    const float middle = -kFirstColumn + kBay * (static_cast<float>(i) + 0.5f);
    if (i % 2 == 1) windows.push_back({middle - 0.55f, middle + 0.55f, 4 * kCourse, 9 * kCourse});
  }
  stage.place(block_wall(palette, kLength + 0.5f, windows, 31), at(-kHalfWidth, 0, 0.25f) * turned(90));
  std::vector<Opening> mirrored;
  for (auto o = windows.rbegin(); o != windows.rend(); ++o)
    mirrored.push_back({kLength + 0.5f - o->right, kLength + 0.5f - o->left, o->low, o->high});
  stage.place(block_wall(palette, kLength + 0.5f, mirrored, 32), at(kHalfWidth, 0, -kLength - 0.25f) * turned(-90));
  stage.place(block_wall(palette, 2 * kHalfWidth + 0.96f, {}, 33), at(-kHalfWidth - 0.48f, 0, -kLength));
  // The gate wall, seen from inside: a tall doorway in its middle.
  const float middle = kHalfWidth + 0.48f;
  stage.place(block_wall(palette, 2 * kHalfWidth + 0.96f, {{middle - 1.5f, middle + 1.5f, 0, 8 * kCourse}}, 34),
              at(kHalfWidth + 0.48f, 0, 0) * turned(180));
  // Painted bands along the side walls.
  Model bands{"bands", {}};
  for (const float side : {-1.0f, 1.0f}) {
    const auto band = [&](uint32_t material, float low, float high, float out) {
      const float a = side * (kHalfWidth - out), b = side * (kHalfWidth + 0.1f);
      add_box(bands.in(material), {std::min(a, b), low, -kLength - 0.1f}, {std::max(a, b), high, 0.1f});
    };
    band(palette.limestone, 1.5f * kCourse, 1.5f * kCourse + 0.10f, 0.05f);
    band(palette.red_band, 10.0f * kCourse - 0.02f, 10.5f * kCourse, 0.02f);
    band(palette.limestone, 10.5f * kCourse - 0.01f, 10.5f * kCourse + 0.14f, 0.08f);
  }
  stage.place(std::move(bands));
}

void add_roof(Stage& stage, const Palette& palette) {
  Model beams{"architrave", {}};
  const float low = kColumnHeight + 0.005f, end = -kLength - 0.2f;
  for (const float side : {-1.0f, 1.0f}) {
    const float x = side * kColumnX;
    add_box(beams.in(palette.limestone), {x - 0.42f, low, end}, {x + 0.42f, low + 0.38f, 0.2f}, 0.02f);
    add_box(beams.in(palette.red_band), {x - 0.40f, low + 0.37f, end}, {x + 0.40f, low + 0.62f, 0.2f}, 0.01f);
    add_box(beams.in(palette.limestone), {x - 0.47f, low + 0.61f, end}, {x + 0.47f, low + kBeam, 0.2f}, 0.02f);
    for (int i = 0; i < 74; ++i) {  // dentils
      const float z = -0.25f - 0.40f * static_cast<float>(i);
      for (const float face : {-1.0f, 1.0f}) {
        const float a = x + face * 0.39f, b = x + face * 0.455f;
        add_box(beams.in(palette.limestone), {std::min(a, b), low + 0.50f, z - 0.10f},
                {std::max(a, b), low + 0.615f, z + 0.10f}, 0.006f);
      }
    }
  }
  stage.place(std::move(beams));

  // Coffers over the aisles and, but for the broken bays, over the nave.
  const float size = kBay / 2, top = kColumnHeight + kBeam;
  const uint32_t model = stage.add(coffer(palette, size + 0.01f));
  Random random(41);
  const int rows = static_cast<int>(std::ceil(kLength / size));
  for (int row = 0; row < rows; ++row) {
    const float z = -size * (static_cast<float>(row) + 0.5f);
    for (int k = -4; k <= 3; ++k) {
      const float x = size * (static_cast<float>(k) + 0.5f);
      const bool broken =
          std::abs(x) < size * 2.2f && ((row >= 5 && row <= 8) || (row == 9 && k < 0) || (row == 4 && k == 1) ||
                                        (row >= 13 && row <= 14 && std::abs(x) < size));
      if (!broken) stage.place(model, at(x, top - random.range(0.030f, 0.040f), z));
    }
  }
}

}  // namespace gnomon::scenes::assets::temple
