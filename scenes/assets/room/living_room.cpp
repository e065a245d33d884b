#include "scenes/assets/built_in.h"
#include "scenes/assets/cutout.h"
#include "scenes/assets/plants.h"
#include "scenes/assets/room/props.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets {
namespace room {

Palette::Palette(Stage& stage) {
  const auto colour = [&stage](const char* name, uint32_t rgb, float roughness = 0.8f, float metallic = 0.0f) {
    Material material;
    material.name = name, material.base_color = linear(rgb);
    material.roughness = roughness, material.metallic = metallic;
    return stage.add(std::move(material));
  };
  plaster = colour("plaster", 0xf3ebdf), blush_wall = colour("blush wall", 0xd8a596);
  ceiling = colour("ceiling", 0xf7f3ec), white_paint = colour("white paint", 0xf4f1ea, 0.5f);
  const uint32_t boards[] = {0xc08f5f, 0xb28150, 0xcb9c6c, 0xa97747};
  for (int i = 0; i < 4; ++i) floor[i] = colour("floor board", boards[i], 0.5f);
  floor_gap = colour("floor gap", 0x4a3524);
  walnut = colour("walnut", 0x7a5033, 0.5f), oak = colour("oak", 0xc89d6b, 0.5f);
  black_metal = colour("black metal", 0x35322f, 0.4f), brass = colour("brass", 0xd1a552, 0.3f);
  chrome = colour("steel", 0xc9ccd0, 0.2f), glass_green = colour("green glass", 0x7fae94, 0.1f);
  sofa = colour("sofa cloth", 0x3f7a78), mustard = colour("mustard cloth", 0xdea53a),
  rose = colour("rose cloth", 0xd98f80);
  cream = colour("cream cloth", 0xf0e4cf), leather = colour("leather", 0xa9632f, 0.5f);
  rug_field = colour("rug wool", 0xefe3cf), rug_border = colour("rug pattern", 0xb4563c);
  curtain = colour("linen", 0xe9d9bd), blind = colour("blind", 0xf2e8d4);
  porcelain = colour("porcelain", 0xf8f6f0, 0.2f), stoneware = colour("stoneware", 0x5f86a0, 0.4f),
  terracotta = colour("terracotta", 0xc4673f);
  paper = colour("paper", 0xf5efdf), soil = colour("soil", 0x4b382a), bark = colour("bark", 0x84684a);
  fig_leaf = colour("fig leaf", 0x4f8a3c, 0.5f), fern_leaf = colour("fern leaf", 0x6aa544),
  snake_leaf = colour("snake plant", 0x5b8f5a, 0.5f);
  lemon = colour("lemon", 0xf2cf3f), orange = colour("orange", 0xee8a2a), apple = colour("apple", 0xc23a2e);
  shade = colour("lamp shade", 0xe7b64d, 0.4f), rattan = colour("rattan", 0xd4a468);
  const uint32_t books[] = {0xb5483a, 0x2f5f74, 0xe0b04c, 0x6d7f4e, 0xefe2c8, 0x8c4a5e, 0x3e4a5c, 0xd98d5f};
  for (int i = 0; i < 8; ++i) book[i] = colour("book", books[i]);
  const uint32_t papers[] = {0xe9a23b, 0xd9603f, 0x2f6f73, 0xb7472a, 0xe6b89c};
  for (int i = 0; i < 5; ++i) art[i] = colour("cut paper", papers[i]);
  Material cut;
  cut.name = "lattice", cut.base_color = linear(0x9a6a44), cut.cutout = static_cast<uint32_t>(stage.images.size());
  stage.images.push_back(lattice_png(4));
  screen = stage.add(std::move(cut));
  stage.dress({plaster, blush_wall, ceiling}, Pattern::plaster, 0.9f);
  stage.dress({floor[0], floor[1], floor[2], floor[3], oak}, Pattern::wood, 0.9f);
  stage.dress({walnut, bark}, Pattern::wood, 0.7f);
  stage.dress({sofa, mustard, rose, cream}, Pattern::weave, 0.14f);
  stage.dress({curtain, blind}, Pattern::weave, 0.10f), stage.dress({rattan}, Pattern::weave, 0.30f);
  stage.dress({rug_field, rug_border}, Pattern::wool, 0.22f), stage.dress({leather}, Pattern::leather, 0.25f);
  stage.dress({terracotta, stoneware}, Pattern::clay, 0.35f), stage.dress({soil}, Pattern::ground, 0.3f);
  stage.dress({brass}, Pattern::hammered, 0.3f);
}

}  // namespace room

namespace {

using room::Palette;

void add_potted(Stage& stage, const Palette& palette, Shrub shrub, uint32_t leaf_material, float pot_radius,
                float pot_height, uint32_t pot, const glm::mat4& placement) {
  Model model{"potted plant", {}};
  const float r = pot_radius, h = pot_height;
  append(model.in(pot), turned_vessel({{0, -0.002f},
                                       {0.68f * r, -0.002f},
                                       {0.74f * r, 0.03f * h},
                                       {0.95f * r, 0.7f * h},
                                       {r, 0.98f * h},
                                       {0.97f * r, h},
                                       {0.91f * r, 0.98f * h},
                                       {0.88f * r, 0.85f * h},
                                       {0, 0.84f * h}},
                                      40, 2));
  append(model.in(palette.soil), barrel(30, 4, [=](float u, float v) {
           const float a = 6.2831853f * u, s = 1 - v;
           return glm::vec3(0.90f * r * s * std::cos(a) + 0.001f,
                            h * (0.86f + 0.04f * v) + 0.006f * std::sin(7 * a) * s, -0.90f * r * s * std::sin(a));
         }));
  const glm::mat4 up = at(0, 0.88f * h, 0);
  if (!shrub.wood.triangles.empty()) append(model.in(palette.bark), shrub.wood, up);
  append(model.in(leaf_material), shrub.leaves, up);
  stage.place(std::move(model), placement);
}

void furnish_living_side(Stage& stage, const Palette& p) {
  stage.place(room::sofa(p), at(2.35f, 0, 0.56f));
  stage.place(room::rug(p), at(2.55f, 0, 2.30f));
  const glm::vec3 table(2.75f, 0.022f, 2.35f);
  stage.place(room::coffee_table(p), at(table));
  stage.place(room::book_pile(p, 5), at(table + glm::vec3(-0.20f, room::kCoffeeTop, -0.15f)) * turned(25));
  stage.place(room::fruit_bowl(p), at(table + glm::vec3(0.20f, room::kCoffeeTop, -0.12f)));
  stage.place(room::teapot(p), at(table + glm::vec3(-0.10f, room::kCoffeeTop, 0.22f)) * turned(-30));
  const uint32_t cup = stage.add(room::cup(p));
  stage.place(cup, at(table + glm::vec3(0.14f, room::kCoffeeTop, 0.26f)) * turned(-50));
  stage.place(cup, at(table + glm::vec3(-0.33f, room::kCoffeeTop, 0.14f)) * turned(140));
  const uint32_t armchair = stage.add(room::armchair(p));
  stage.place(armchair, at(1.05f, 0.018f, 3.15f) * turned(118));
  stage.place(armchair, at(2.05f, 0, 4.05f) * turned(165));
  stage.place(room::pouf(p), at(3.35f, 0.02f, 3.35f));
  stage.place(room::arc_lamp(p), at(4.15f, 0, 0.55f) * turned(-45));
}

void furnish_dining_side(Stage& stage, const Palette& p) {
  const glm::vec3 table(6.35f, 0, 3.05f);
  stage.place(room::dining_table(p), at(table));
  const uint32_t chair = stage.add(room::dining_chair(p)), setting = stage.add(room::place_setting(p));
  const float turns[] = {88, 93, -84, -97};
  for (int i = 0; i < 4; ++i) {
    const float side = i < 2 ? -1.0f : 1.0f, z = i % 2 ? 0.45f : -0.45f;
    stage.place(chair, at(table + glm::vec3(side * (i == 2 ? 0.78f : 0.66f), 0, z)) * turned(turns[i]));
    stage.place(setting, at(table + glm::vec3(side * 0.31f, room::kTableTop + 0.001f, z)) *
                             turned(side < 0 ? 90.0f : -90.0f) * turned(180));
  }
  stage.place(room::carafe(p), at(table + glm::vec3(0.03f, room::kTableTop + 0.004f, 0.22f)));
  stage.place(room::flower_vase(p), at(table + glm::vec3(-0.02f, room::kTableTop + 0.004f, -0.12f)));
  stage.place(room::pendant(p), at(table.x, room::kHeight, table.z));
  stage.place(room::bookcase(p), at(6.35f, 0, 0.19f));
  stage.place(room::lattice_screen(p), at(4.75f, 0, 4.95f) * turned(84));
}

void furnish_walls(Stage& stage, const Palette& p) {
  stage.place(room::picture(p, 0.62f, 0.82f, 1), at(1.62f, 1.72f, 0));
  stage.place(room::picture(p, 0.90f, 0.82f, 2), at(2.50f, 1.72f, 0));
  stage.place(room::picture(p, 0.62f, 0.82f, 6), at(3.38f, 1.72f, 0));
  stage.place(room::picture(p, 1.30f, 0.95f, 4), at(room::kWidth, 1.65f, 3.05f) * turned(-90));
  stage.place(room::picture(p, 0.80f, 0.60f, 9), at(3.6f, 1.60f, room::kDepth) * turned(180));
  stage.place(room::sideboard(p), at(3.35f, 0, 5.34f) * turned(180));
  stage.place(room::record_player(p), at(3.75f, room::kSideboardTop, 5.36f) * turned(180));
  stage.place(room::vase(1, p.terracotta), at(2.70f, room::kSideboardTop, 5.38f));
  stage.place(room::vase(2, p.porcelain), at(2.98f, room::kSideboardTop, 5.36f));
  stage.place(room::book_pile(p, 8), at(3.22f, room::kSideboardTop, 5.37f) * turned(100));
}

void add_plants(Stage& stage, const Palette& p) {
  add_potted(stage, p, fig_tree(1.45f, 3), p.fig_leaf, 0.22f, 0.40f, p.porcelain, at(0.62f, 0, 4.98f));
  add_potted(stage, p, snake_plant(0.85f, 16, 4), p.snake_leaf, 0.17f, 0.28f, p.terracotta, at(7.65f, 0, 5.2f));
  add_potted(stage, p, fern(0.50f, 15, 5), p.fern_leaf, 0.15f, 0.24f, p.stoneware, at(4.75f, 0, 0.42f));
  add_potted(stage, p, fern(0.34f, 10, 6), p.fern_leaf, 0.10f, 0.15f, p.terracotta,
             at(0.02f, room::kWindowLow + 0.005f, 4.2f) * scaled(0.8f));
}

void add_lights(Stage& stage) {
  Light pendant;
  pendant.name = "pendant", pendant.position = {6.35f, room::kHeight - room::kPendantDrop, 3.05f};
  pendant.color = {1.0f, 0.80f, 0.58f}, pendant.intensity = 20.0f, pendant.radius = 0.08f;
  Light arc;
  arc.name = "arc lamp", arc.position = glm::vec3(at(4.15f, 0, 0.55f) * turned(-45) * glm::vec4(room::kArcBulb, 1));
  arc.color = {1.0f, 0.84f, 0.66f}, arc.intensity = 15.0f, arc.radius = 0.05f;
  Light sun;
  sun.name = "low sun", sun.kind = LightKind::spot, sun.position = {-11.0f, 6.4f, 0.2f};
  sun.direction = glm::normalize(glm::vec3(0.0f, 1.35f, 2.8f) - sun.position);
  sun.color = {1.0f, 0.88f, 0.70f}, sun.intensity = 2600.0f, sun.inner_cone = 0.20f, sun.outer_cone = 0.26f;
  sun.radius = 0.25f;
  stage.lights = {pendant, arc, sun};
}

}  // namespace

Stage make_living_room() {
  Stage stage;
  stage.name = "living_room";
  const Palette palette(stage);
  room::add_shell(stage, palette);
  room::add_window_dressing(stage, palette);
  furnish_living_side(stage, palette);
  furnish_dining_side(stage, palette);
  furnish_walls(stage, palette);
  add_plants(stage, palette);
  add_lights(stage);
  stage.surroundings = {.ambient_above = {0.33f, 0.31f, 0.30f},
                        .ambient_below = {0.28f, 0.23f, 0.18f},
                        .zenith = {0.35f, 0.62f, 1.35f},
                        .horizon = {3.0f, 1.75f, 0.85f},
                        .ground = {0.30f, 0.30f, 0.20f},
                        .clouds = 0.4f};
  stage.vertical_fov = 0.92f;
  stage.flight = fly({{5.00f, 1.58f, 3.85f},
                      {4.80f, 1.55f, 3.10f},
                      {4.55f, 1.50f, 2.00f},
                      {3.75f, 1.48f, 2.05f},
                      {3.55f, 1.50f, 3.10f},
                      {4.05f, 1.55f, 4.00f}},
                     {{2.10f, 0.85f, 1.30f},
                      {2.00f, 0.90f, 0.80f},
                      {0.40f, 1.00f, 2.40f},
                      {0.80f, 0.85f, 4.60f},
                      {5.20f, 0.90f, 5.40f},
                      {6.60f, 1.10f, 1.50f}},
                     14.0f);
  return stage;
}

}  // namespace gnomon::scenes::assets
