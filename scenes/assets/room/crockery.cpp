#include <cmath>

#include "scenes/assets/random.h"
#include "scenes/assets/room/props.h"
#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets::room {
namespace {

Mesh plate(float radius) {
  return turned_vessel({{0, 0.002f},
                        {0.55f * radius, 0.002f},
                        {0.60f * radius, 0.004f},
                        {0.96f * radius, 0.020f},
                        {radius, 0.024f},
                        {0.97f * radius, 0.0255f},
                        {0.66f * radius, 0.0115f},
                        {0.55f * radius, 0.0085f},
                        {0, 0.008f}},
                       32, 2);
}

Mesh bowl(float radius, float height) {
  return turned_vessel({{0, 0.001f},
                        {0.45f * radius, 0.001f},
                        {0.5f * radius, 0.06f * height},
                        {0.82f * radius, 0.42f * height},
                        {radius, height},
                        {0.965f * radius, 1.01f * height},
                        {0.77f * radius, 0.46f * height},
                        {0.45f * radius, 0.14f * height},
                        {0, 0.10f * height}},
                       28, 2);
}

Mesh wine_glass() {
  return turned_vessel({{0, 0.001f},
                        {0.033f, 0.001f},
                        {0.034f, 0.004f},
                        {0.010f, 0.010f},
                        {0.0045f, 0.025f},
                        {0.0045f, 0.080f},
                        {0.012f, 0.092f},
                        {0.036f, 0.118f},
                        {0.040f, 0.150f},
                        {0.033f, 0.195f},
                        {0.0318f, 0.195f},
                        {0.0385f, 0.150f},
                        {0.034f, 0.120f},
                        {0.010f, 0.097f},
                        {0, 0.095f}},
                       22, 2);
}

Mesh spoon_or_fork(float bowl_width) {
  return barrel(6, 14, [=](float u, float v) {
    const float a = 6.2831853f * u;
    const float head = std::exp(-std::pow((v - 0.87f) / 0.085f, 2.0f));
    const float half = 0.003f + bowl_width * head + 0.0025f * std::exp(-std::pow(v / 0.12f, 2.0f));
    const float lift = 0.006f * std::pow(v - 0.2f, 2.0f) * 4 - 0.004f * head;
    return glm::vec3(half * std::cos(a), 0.0028f + lift + 0.0012f * std::sin(a), 0.19f * (v - 0.5f));
  });
}

Mesh knife() {
  return barrel(6, 10, [](float u, float v) {
    const float a = 6.2831853f * u;
    const float blade = v > 0.45f ? 1.0f : 0.0f;
    const float half = 0.0048f + 0.004f * blade * (1 - std::pow(std::max(v - 0.45f, 0.0f) / 0.56f, 3.0f));
    return glm::vec3(half * std::cos(a), 0.003f + (0.0024f - 0.0015f * blade) * std::sin(a), 0.21f * (v - 0.5f));
  });
}

Mesh handle(float height, float reach, float radius) {
  return tube(curve(std::vector<glm::vec3>{{0, 0, 0},
                                           {0.8f * reach, 0.05f * height, 0},
                                           {reach, 0.45f * height, 0},
                                           {0.75f * reach, 0.95f * height, 0},
                                           {0, height, 0}},
                    5),
              radius, 10);
}

Mesh cup_body() {
  return turned_vessel({{0, 0.002f},
                        {0.020f, 0.002f},
                        {0.022f, 0.005f},
                        {0.034f, 0.022f},
                        {0.039f, 0.062f},
                        {0.0375f, 0.063f},
                        {0.032f, 0.026f},
                        {0.018f, 0.009f},
                        {0, 0.008f}},
                       32, 2);
}

}  // namespace

Model place_setting(const Palette& palette) {
  Model model{"place setting", {}};
  append(model.in(palette.stoneware), plate(0.135f));
  append(model.in(palette.porcelain), plate(0.102f), at(0, 0.0095f, 0));
  append(model.in(palette.porcelain), bowl(0.066f, 0.055f), at(0, 0.0195f, 0));
  append(model.in(palette.chrome), spoon_or_fork(0.0085f), at(-0.172f, 0, 0) * turned(180));
  append(model.in(palette.chrome), knife(), at(0.168f, 0, 0) * turned(180));
  append(model.in(palette.chrome), spoon_or_fork(0.015f), at(0.195f, 0, 0.005f) * turned(180));
  append(model.in(palette.glass_green), wine_glass(), at(0.145f, 0, -0.165f));
  append(model.in(palette.rose), rounded_box({0.055f, 0.016f, 0.15f}, 0.006f, 2), at(-0.225f, 0.0085f, 0));
  return model;
}

Model carafe(const Palette& palette) {
  Model model{"carafe", {}};
  append(model.in(palette.glass_green), turned_vessel({{0, 0.001f},
                                                       {0.050f, 0.002f},
                                                       {0.060f, 0.012f},
                                                       {0.062f, 0.09f},
                                                       {0.030f, 0.155f},
                                                       {0.024f, 0.21f},
                                                       {0.032f, 0.245f},
                                                       {0.030f, 0.246f},
                                                       {0.021f, 0.21f},
                                                       {0.026f, 0.155f},
                                                       {0.050f, 0.10f},
                                                       {0, 0.09f}},
                                                      32, 2));
  return model;
}

Model fruit_bowl(const Palette& palette) {
  Model model{"fruit bowl", {}};
  append(model.in(palette.terracotta), bowl(0.17f, 0.085f));
  const Mesh round = turned_vessel({{0, -0.034f},
                                    {0.012f, -0.037f},
                                    {0.034f, -0.018f},
                                    {0.038f, 0.006f},
                                    {0.024f, 0.032f},
                                    {0.008f, 0.034f},
                                    {0, 0.028f}},
                                   20, 2);
  const Mesh pointed = turned_vessel({{0, -0.044f},
                                      {0.006f, -0.041f},
                                      {0.024f, -0.024f},
                                      {0.030f, 0},
                                      {0.024f, 0.024f},
                                      {0.006f, 0.042f},
                                      {0, 0.046f}},
                                     20, 2);
  const glm::vec3 seats[] = {{-0.07f, 0.062f, 0.03f},   {0.005f, 0.057f, 0.075f}, {0.075f, 0.062f, 0.02f},
                             {-0.03f, 0.060f, -0.065f}, {0.05f, 0.062f, -0.06f},  {0.0f, 0.112f, 0.0f},
                             {0.0f, 0.05f, 0.005f}};
  const uint32_t colours[] = {palette.orange, palette.apple, palette.lemon, palette.apple,
                              palette.orange, palette.lemon, palette.orange};
  for (int i = 0; i < 7; ++i) {
    const bool lemon = colours[i] == palette.lemon;
    append(model.in(colours[i]), lemon ? pointed : round,
           at(seats[i]) * turned(50.0f * static_cast<float>(i), {0.3f, 1, 0.2f}) *
               turned(lemon ? 80.0f : 15.0f, {1, 0, 0}));
  }
  return model;
}

Model teapot(const Palette& palette) {
  Model model{"teapot", {}};
  Mesh& clay = model.in(palette.stoneware);
  append(clay, turned_vessel({{0, 0.001f},
                              {0.050f, 0.001f},
                              {0.075f, 0.03f},
                              {0.088f, 0.07f},
                              {0.070f, 0.112f},
                              {0.040f, 0.124f},
                              {0.036f, 0.131f},
                              {0.012f, 0.138f},
                              {0.009f, 0.145f},
                              {0.014f, 0.155f},
                              {0.008f, 0.163f},
                              {0, 0.164f}},
                             32, 2));
  append(clay, tube(
                   curve(
                       std::vector<glm::vec3>{
                           {0.070f, 0.045f, 0}, {0.105f, 0.062f, 0}, {0.125f, 0.098f, 0}, {0.152f, 0.118f, 0}},
                       6),
                   [](float t) { return 0.019f - 0.010f * t; }, 14));
  append(clay, handle(0.075f, -0.068f, 0.0075f), at(-0.075f, 0.035f, 0));
  return model;
}

Model cup(const Palette& palette) {
  Model model{"cup", {}};
  append(model.in(palette.porcelain), cup_body(), at(0, 0.010f, 0));
  append(model.in(palette.porcelain), handle(0.036f, 0.026f, 0.0038f), at(0.034f, 0.026f, 0));
  append(model.in(palette.porcelain), plate(0.068f));
  return model;
}

Model vase(int shape, uint32_t material) {
  const std::vector<glm::vec2> shapes[] = {{{0, 0.001f},
                                            {0.045f, 0.001f},
                                            {0.075f, 0.05f},
                                            {0.085f, 0.12f},
                                            {0.050f, 0.20f},
                                            {0.028f, 0.24f},
                                            {0.038f, 0.28f},
                                            {0.034f, 0.281f},
                                            {0.023f, 0.24f},
                                            {0.04f, 0.20f},
                                            {0, 0.16f}},
                                           {{0, 0.001f},
                                            {0.060f, 0.001f},
                                            {0.065f, 0.02f},
                                            {0.058f, 0.15f},
                                            {0.070f, 0.30f},
                                            {0.066f, 0.302f},
                                            {0.052f, 0.16f},
                                            {0.05f, 0.05f},
                                            {0, 0.04f}},
                                           {{0, 0.001f},
                                            {0.05f, 0.002f},
                                            {0.095f, 0.06f},
                                            {0.095f, 0.11f},
                                            {0.05f, 0.15f},
                                            {0.04f, 0.16f},
                                            {0.043f, 0.17f},
                                            {0.036f, 0.168f},
                                            {0.04f, 0.15f},
                                            {0.08f, 0.10f},
                                            {0, 0.03f}}};
  Model model{"vase", {}};
  append(model.in(material), turned_vessel(shapes[shape], 36, 3));
  return model;
}

Model flower_vase(const Palette& palette) {
  Random random(61);
  Model model = vase(1, palette.porcelain);
  model.name = "flower vase";
  for (int i = 0; i < 7; ++i) {
    const float a = 2.4f * static_cast<float>(i), lean = random.range(0.04f, 0.16f),
                tall = random.range(0.40f, 0.58f);
    const glm::vec3 tip(lean * std::cos(a), tall, lean * std::sin(a));
    append(model.in(palette.fern_leaf), tube(curve(std::vector<glm::vec3>{{0.2f * tip.x, 0.06f, 0.2f * tip.z},
                                                                          {0.35f * tip.x, 0.30f, 0.35f * tip.z},
                                                                          tip},
                                                   4),
                                             0.0025f, 6));
    const Mesh petal = sheet(2, 3, 0.001f, [](float u, float v) {
      return glm::vec3((u - 0.5f) * 0.020f * std::sin(3.0f * v + 0.12f), 0.034f * v - 0.012f * v * v,
                       0.020f * v * v);
    });
    const uint32_t colour = i % 3 == 0 ? palette.mustard : palette.rose;
    for (int ring = 0; ring < 2; ++ring) {
      for (int k = 0; k < 7; ++k) {
        append(model.in(colour), petal,
               at(tip) * pointing(tip - glm::vec3(0, 0.2f, 0)) *
                   turned(51.4f * static_cast<float>(k) + 22.0f * static_cast<float>(ring)) *
                   turned(62.0f - 30.0f * static_cast<float>(ring), {1, 0, 0}));
      }
    }
    append(model.in(palette.lemon), sphere(0.009f, 10), at(tip + glm::vec3(0, 0.006f, 0)));
  }
  return model;
}

}  // namespace gnomon::scenes::assets::room
