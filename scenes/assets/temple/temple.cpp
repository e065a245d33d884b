#include <cmath>

#include "scenes/assets/built_in.h"
#include "scenes/assets/cutout.h"
#include "scenes/assets/random.h"
#include "scenes/assets/shapes.h"
#include "scenes/assets/temple/props.h"

namespace gnomon::scenes::assets {
namespace temple {

Palette::Palette(Stage& stage) {
  const auto colour = [&stage](const char* name, uint32_t rgb, float roughness = 0.9f, float metallic = 0.0f) {
    Material material;
    material.name = name, material.base_color = linear(rgb);
    material.roughness = roughness, material.metallic = metallic;
    return stage.add(std::move(material));
  };
  limestone = colour("limestone", 0xe9dcc2), sandstone = colour("sandstone", 0xd9bd8f);
  const uint32_t slabs[] = {0xcdb891, 0xbfa67d, 0xd8c6a3}, blocks[] = {0xdcc199, 0xd0b288, 0xe4cda8};
  for (int i = 0; i < 3; ++i) paving[i] = colour("paving", slabs[i]), block[i] = colour("block", blocks[i]);
  joint = colour("joint", 0x7d6a4f), earth = colour("earth", 0xa8925c), cypress = colour("cypress", 0x4c6a38);
  red_band = colour("red paint", 0xb1492f), blue_band = colour("blue paint", 0x2f5f8c);
  marble = colour("marble", 0xf3eee4, 0.5f), granite = colour("granite", 0x8d7b74, 0.6f);
  bronze = colour("bronze", 0x8a6a3c, 0.4f), gold = colour("gold", 0xe3b04b, 0.3f);
  terracotta = colour("terracotta", 0xbf6a42), coal = colour("embers", 0xf0813a);
  stage.materials[coal].emissive = {1.0f, 0.35f, 0.08f};
  ivy_stem = colour("ivy stem", 0x6a563c), cloth = colour("red cloth", 0xa83a32);
  Material leaves;
  leaves.name = "ivy", leaves.base_color = linear(0x5f9440),
  leaves.cutout = static_cast<uint32_t>(stage.images.size());
  stage.images.push_back(ivy_leaf_png());
  ivy_leaf = stage.add(std::move(leaves));
  stage.dress({limestone, sandstone, red_band, blue_band}, Pattern::stone, 1.7f);
  stage.dress({paving[0], paving[1], paving[2], block[0], block[1], block[2]}, Pattern::stone, 1.4f);
  stage.dress({joint}, Pattern::plaster, 0.7f);
  stage.dress({marble}, Pattern::marble, 1.1f), stage.dress({granite}, Pattern::marble, 0.5f);
  stage.dress({bronze}, Pattern::patina, 0.8f), stage.dress({gold}, Pattern::hammered, 0.45f);
  stage.dress({terracotta}, Pattern::clay, 0.6f), stage.dress({cloth}, Pattern::weave, 0.16f);
  stage.dress({earth}, Pattern::ground, 14.0f), stage.dress({cypress}, Pattern::foliage, 1.3f);
  stage.dress({ivy_stem}, Pattern::wood, 0.4f);
}

}  // namespace temple

namespace {

using namespace temple;

constexpr int kBrokenColumn = 3;  // of the eastern row

float column_z(int i) { return kFirstColumn - kBay * static_cast<float>(i); }

void add_columns(Stage& stage, const Palette& palette) {
  const uint32_t whole = stage.add(column(palette)), broken = stage.add(broken_column(palette));
  for (const float side : {-1.0f, 1.0f}) {
    for (int i = 0; i < kColumns - 1; ++i) {
      const bool fallen = side > 0 && i == kBrokenColumn;
      stage.place(fallen ? broken : whole, at(side * kColumnX, 0, column_z(i)));
    }
    for (int i = 0; i < 2; ++i) {  // on the dais, shorter by its height
      const float lower = (kColumnHeight - kDais) / kColumnHeight;
      stage.place(whole, at(side * kColumnX, kDais, column_z(kColumns - 1 + i)) * scaled(0.94f, lower, 0.94f));
    }
  }
}

void add_figures(Stage& stage, const Palette& palette) {
  const uint32_t guard = stage.add(guardian(palette)), base = stage.add(plinth(palette, 1.0f, 0.8f));
  for (const float side : {-1.0f, 1.0f}) {
    for (const float z : {-4.2f, -11.4f, -18.6f}) {
      stage.place(base, at(side * 6.3f, 0, z) * turned(-90 * side));
      stage.place(guard, at(side * 6.3f, 0.795f, z) * turned(-90 * side) * scaled(side, 1, 1));
    }
  }
  const uint32_t holder = stage.add(bearer(palette)), lion = stage.add(sphinx(palette)),
                 low = stage.add(plinth(palette, 1.05f, 0.5f));
  for (const float side : {-1.0f, 1.0f}) {
    stage.place(low, at(side * 1.95f, kDais, -28.4f));
    stage.place(holder, at(side * 1.95f, kDais + 0.495f, -28.4f) * scaled(1.12f));
    stage.place(lion, at(side * 3.7f, kDais + 0.118f, kDaisFront + 0.98f) * scaled(0.70f));
  }
}

void add_furnishing(Stage& stage, const Palette& palette) {
  const uint32_t fire = stage.add(brazier(palette)), lamp = stage.add(hanging_lamp(palette));
  for (const float side : {-1.0f, 1.0f}) {
    stage.place(fire, at(side * 2.35f, 0, -7.8f) * turned(20 * side));
    stage.place(fire, at(side * 5.0f, 0, -21.9f) * turned(50 * side));
  }
  const float ceiling = kColumnHeight + kBeam;
  stage.place(lamp, at(-5.2f, ceiling, -14.6f));
  stage.place(lamp, at(5.2f, ceiling, -7.6f));
  stage.place(altar(palette), at(0, kDais, -27.2f));
  stage.place(sun_disk(palette), at(0, 4.35f, -kLength + 0.05f) * scaled(1.15f));
  const uint32_t tall = stage.add(urn(palette, 0)), slim = stage.add(urn(palette, 1));
  const glm::vec3 urns[] = {{-6.2f, 0, -1.2f},  {6.2f, 0, -1.2f},       {-6.3f, 0, -8.4f},    {-2.3f, 0, -14.9f},
                            {6.35f, 0, -14.9f}, {-5.9f, kDais, -29.0f}, {5.9f, kDais, -29.0f}};
  float turn = 0;
  for (const glm::vec3& p : urns) {
    stage.place(tall, at(p) * turned(turn += 47));
    stage.place(slim, at(p + glm::vec3(p.x > 0 ? -0.15f : 0.15f, 0, 0.68f)) * turned(turn * 1.7f));
  }
  const uint32_t flag = stage.add(banner(palette, 2));
  for (const float x : {-4.9f, 4.9f}) stage.place(flag, at(x, 5.6f, -kLength + 0.06f));
  for (const float x : {-4.2f, 4.2f}) stage.place(flag, at(x, 5.6f, -0.06f) * turned(180));
}

void add_decay(Stage& stage, const Palette& palette) {
  stage.place(rubble(palette, 3, 1.5f, 34), at(2.7f, 0, -13.9f));
  stage.place(rubble(palette, 4, 1.1f, 18), at(5.9f, 0, -12.9f) * scaled(0.7f));
  stage.place(rubble(palette, 5, 1.0f, 16), at(-2.2f, 0, -11.4f) * scaled(0.6f));
  stage.place(ivy_wall(palette, {2.6f, 3.8f}, false, 9), at(-kHalfWidth + 0.02f, 0, -9.6f) * turned(90));
  stage.place(ivy_wall(palette, {3.0f, 4.6f}, false, 10), at(kHalfWidth - 0.02f, 0, -14.6f) * turned(-90));
  stage.place(ivy_wall(palette, {3.2f, 2.4f}, true, 11),
              at(-kColumnX + 0.47f, kColumnHeight + 0.80f, -12.6f) * turned(90));
  stage.place(ivy_wall(palette, {2.2f, 2.6f}, true, 12), at(1.7f, kColumnHeight + kBeam + 0.05f, -16.15f));
}

void add_lights(Stage& stage) {
  const auto fire = [&stage](const char* name, glm::vec3 place, float candela, float radius) {
    Light light;
    light.name = name, light.position = place, light.color = {1.0f, 0.62f, 0.32f}, light.intensity = candela;
    light.radius = radius;
    stage.lights.push_back(light);
  };
  Light sun;
  sun.name = "sun", sun.kind = LightKind::directional, sun.color = {1.0f, 0.93f, 0.80f}, sun.intensity = 5.0f;
  sun.direction = glm::normalize(glm::vec3(-0.46f, -0.85f, -0.22f));
  stage.lights.push_back(sun);
  const float fire_radius = 0.2f, flame_radius = 0.07f;
  fire("brazier west", {-2.35f, kFireHeight, -7.8f}, 24, fire_radius);
  fire("brazier east", {2.35f, kFireHeight, -7.8f}, 24, fire_radius);
  fire("brazier stairs west", {-5.0f, kFireHeight, -21.9f}, 26, fire_radius);
  fire("brazier stairs east", {5.0f, kFireHeight, -21.9f}, 26, fire_radius);
  const float flame = kColumnHeight + kBeam - kLampDrop;
  fire("lamp west", {-5.2f, flame, -14.6f}, 55, flame_radius);
  fire("lamp east", {5.2f, flame, -7.6f}, 55, flame_radius);
  Light beam;
  beam.name = "light over the altar", beam.kind = LightKind::spot, beam.position = {0.0f, 7.6f, -24.6f};
  beam.direction = glm::normalize(glm::vec3(0.0f, 1.9f, -28.4f) - beam.position);
  beam.color = {0.86f, 0.93f, 1.0f}, beam.intensity = 110, beam.inner_cone = 0.45f, beam.outer_cone = 0.62f;
  beam.radius = 0.3f;
  stage.lights.push_back(beam);
}

}  // namespace

Stage make_temple() {
  Stage stage;
  stage.name = "temple";
  const Palette palette(stage);
  add_ground(stage, palette);
  add_walls(stage, palette);
  add_roof(stage, palette);
  add_columns(stage, palette);
  add_figures(stage, palette);
  add_furnishing(stage, palette);
  add_decay(stage, palette);
  add_country(stage, palette);
  add_lights(stage);
  stage.surroundings = {.ambient_above = {0.085f, 0.095f, 0.115f},
                        .ambient_below = {0.080f, 0.062f, 0.042f},
                        .zenith = {0.22f, 0.48f, 1.15f},
                        .horizon = {1.15f, 1.20f, 1.25f},
                        .ground = {0.45f, 0.42f, 0.32f},
                        .clouds = 0.45f};
  stage.vertical_fov = 0.96f;
  stage.flight = fly({{0.0f, 1.75f, -2.0f},
                      {-0.3f, 1.70f, -7.0f},
                      {-0.5f, 1.70f, -12.0f},
                      {0.0f, 1.70f, -17.0f},
                      {0.0f, 1.85f, -20.6f},
                      {0.0f, 2.62f, -23.9f},
                      {1.0f, 2.65f, -25.3f},
                      {2.2f, 2.62f, -24.3f},
                      {2.1f, 1.95f, -21.4f},
                      {2.6f, 1.70f, -19.0f},
                      {4.6f, 1.70f, -17.6f},
                      {5.0f, 1.70f, -12.5f},
                      {5.0f, 1.70f, -8.0f},
                      {4.5f, 1.70f, -4.6f},
                      {2.0f, 1.75f, -3.0f}},
                     {{0.0f, 2.2f, -12.0f},
                      {-0.4f, 2.6f, -17.0f},
                      {1.2f, 2.4f, -22.0f},
                      {0.0f, 3.0f, -29.0f},
                      {0.0f, 3.2f, -30.0f},
                      {-0.8f, 2.8f, -30.0f},
                      {-4.0f, 2.6f, -28.5f},
                      {-4.5f, 2.2f, -22.5f},
                      {-3.0f, 1.8f, -15.0f},
                      {3.0f, 1.9f, -12.0f},
                      {4.6f, 1.9f, -8.0f},
                      {4.0f, 1.9f, -3.0f},
                      {1.5f, 2.1f, -1.5f},
                      {-3.0f, 2.2f, -3.0f},
                      {-3.0f, 2.2f, -9.0f}},
                     50.0f);
  return stage;
}

}  // namespace gnomon::scenes::assets
