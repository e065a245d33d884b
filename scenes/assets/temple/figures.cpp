#include <cmath>

#include "scenes/assets/implicit.h"
#include "scenes/assets/shapes.h"
#include "scenes/assets/temple/props.h"

namespace gnomon::scenes::assets::temple {
namespace {

using glm::vec3;

constexpr float kFigureCell = 0.037f, kHeadCell = 0.017f;

// A long robe: an oval skirt whose folds deepen towards the hem, drawn in at the waist (y = 1.30).
float robe(vec3 p, float hem, float waist) {
  const float t = glm::clamp(p.y / 1.30f, 0.0f, 1.0f), a = std::atan2(p.z, p.x);
  const float folds = 0.032f * (1 - 0.7f * t) * std::sin(11 * a + 1.4f * std::sin(3 * a) + 0.8f * p.y);
  const float radius = glm::mix(hem, waist, std::pow(t, 0.8f)) + folds;
  const float side = glm::length(glm::vec2(p.x, p.z * 1.22f)) - radius;
  return std::max({0.8f * side, -p.y, p.y - 1.32f});
}

float torso(vec3 p) {
  float d = ellipsoid(p, {0, 1.52f, 0}, {0.215f, 0.31f, 0.145f});
  d = blend(d, capsule(p, {-0.215f, 1.745f, 0}, {0.215f, 1.745f, 0}, 0.078f, 0.078f), 0.11f);
  d = blend(d, ellipsoid(p, {-0.085f, 1.62f, 0.085f}, {0.105f, 0.10f, 0.075f}), 0.07f);
  d = blend(d, ellipsoid(p, {0.085f, 1.62f, 0.085f}, {0.105f, 0.10f, 0.075f}), 0.07f);
  // A mantle from one shoulder to the other hip: a slanting band that stands out a little.
  const float band = std::abs(p.x * 0.8f + (p.y - 1.50f) * 0.62f) - 0.085f;
  return std::min(d, std::max(d - 0.026f, band));
}

float head(vec3 p) {
  const vec3 c(0, 2.06f, 0.015f);
  float d = ellipsoid(p, c, {0.098f, 0.138f, 0.122f});
  d = blend(d, ellipsoid(p, c + vec3(0, -0.085f, 0.045f), {0.062f, 0.060f, 0.066f}), 0.05f);  // jaw
  d = blend(d, capsule(p, {0, 1.78f, -0.01f}, {0, 1.98f, 0.0f}, 0.068f, 0.060f), 0.04f);      // neck
  for (const float side : {-1.0f, 1.0f}) {
    d = carve(d, ball(p, c + vec3(side * 0.040f, 0.020f, 0.125f), 0.026f), 0.025f);  // sockets
    d = blend(d, ball(p, c + vec3(side * 0.038f, 0.017f, 0.098f), 0.017f), 0.008f);  // eyes
  }
  d = blend(d, capsule(p, c + vec3(0, 0.032f, 0.112f), c + vec3(0, -0.030f, 0.140f), 0.010f, 0.019f),
            0.018f);                                                                           // nose
  d = blend(d, ellipsoid(p, c + vec3(0, -0.068f, 0.108f), {0.030f, 0.010f, 0.014f}), 0.012f);  // lips
  return d;
}

// A cloth headdress that falls to both shoulders, striped, with a band over the brow.
float headdress(vec3 p) {
  const vec3 c(0, 2.10f, -0.015f);
  float d = ellipsoid(p, c, {0.128f, 0.130f, 0.140f});
  for (const float side : {-1.0f, 1.0f}) {
    d = blend(d, capsule(p, {side * 0.115f, 2.05f, -0.03f}, {side * 0.150f, 1.72f, 0.045f}, 0.048f, 0.058f), 0.06f);
  }
  d = blend(d, ellipsoid(p, {0, 1.93f, -0.095f}, {0.135f, 0.20f, 0.06f}), 0.08f);
  d += 0.006f * std::sin(75 * p.y);
  const float face = ellipsoid(p, {0, 2.045f, 0.12f}, {0.090f, 0.128f, 0.125f});
  d = std::max(d, -face);
  const vec3 q = p - vec3(0, 2.150f, 0.0f);
  const float brow =
      std::max(std::abs(glm::length(glm::vec2(q.x, q.z * 0.93f)) - 0.122f) - 0.014f, std::abs(q.y) - 0.018f);
  return std::min(d, brow);
}

float arm(vec3 p, vec3 shoulder, vec3 elbow, vec3 wrist) {
  float d = capsule(p, shoulder, elbow, 0.072f, 0.055f);
  d = blend(d, capsule(p, elbow, wrist, 0.055f, 0.038f), 0.04f);
  const vec3 palm = wrist + 0.065f * glm::normalize(wrist - elbow);
  d = blend(d, ellipsoid(p, palm, {0.045f, 0.055f, 0.045f}), 0.03f);
  // Sleeve to the elbow, and a bracelet.
  d = blend(d, capsule(p, shoulder, shoulder + 0.75f * (elbow - shoulder), 0.080f, 0.092f), 0.03f);
  const vec3 ring = elbow + 0.8f * (wrist - elbow), axis = glm::normalize(wrist - elbow);
  const float off = glm::dot(p - ring, axis), out = glm::length(p - ring - off * axis);
  return blend(d, glm::length(glm::vec2(out - 0.040f, off)) - 0.014f, 0.006f);
}

float feet(vec3 p) {
  return std::min(ellipsoid(p, {-0.13f, 0.05f, 0.36f}, {0.065f, 0.055f, 0.12f}),
                  ellipsoid(p, {0.13f, 0.05f, 0.36f}, {0.065f, 0.055f, 0.12f}));
}

float belt(vec3 p) {
  const float ring = std::abs(glm::length(glm::vec2(p.x, p.z * 1.30f)) - 0.205f) - 0.022f;
  const float band = std::max(ring, std::abs(p.y - 1.30f) - 0.045f);
  const float apron = brick(p, {0, 0.98f, 0.235f}, {0.075f, 0.32f, 0.03f}, 0.02f);
  return std::min(band, apron);
}

float body(vec3 p) {
  float d = blend(robe(p, 0.43f, 0.205f), torso(p), 0.05f);
  d = blend(d, belt(p), 0.015f);
  return blend(d, feet(p), 0.02f);
}

// Faces need a finer grid than robes: the head is a piece of its own, its neck and cloth sunk into the body.
Mesh head_piece() {
  return sculpt([](vec3 p) { return std::min(head(p), headdress(p)); }, {-0.25f, 1.62f, -0.25f},
                {0.25f, 2.28f, 0.24f}, kHeadCell);
}

}  // namespace

Model guardian(const Palette& palette) {
  Model model{"guardian", {}};
  const vec3 grip(0.47f, 1.42f, 0.30f);
  append(model.in(palette.marble),
         sculpt(
             [&](vec3 p) {
               float d =
                   blend(body(p), arm(p, {0.235f, 1.735f, 0}, {0.36f, 1.42f, -0.02f}, grip - vec3(0.02f, 0, 0.06f)),
                         0.04f);
               d = blend(d, arm(p, {-0.235f, 1.735f, 0}, {-0.36f, 1.46f, 0.03f}, {-0.10f, 1.52f, 0.21f}), 0.04f);
               return d;
             },
             {-0.56f, -0.03f, -0.48f}, {0.62f, 2.00f, 0.56f}, kFigureCell));
  append(model.in(palette.marble), head_piece());
  // A bronze staff with the sun on its top.
  append(model.in(palette.bronze), tube({{grip.x, -0.01f, grip.z}, {grip.x, 2.42f, grip.z}}, 0.021f, 14));
  append(model.in(palette.gold), sphere(0.045f, 18), at(grip.x, 2.40f, grip.z));
  append(model.in(palette.gold), cylinder(0.115f, -0.018f, 0.018f, 32, 0.012f),
         at(grip.x, 2.58f, grip.z) * turned(90, {1, 0, 0}));
  for (int i = 0; i < 12; ++i) {
    append(model.in(palette.gold),
           tube(
               {{0, 0.10f, 0}, {0, 0.21f, 0}}, [](float t) { return 0.026f * (1 - 0.95f * t); }, 6),
           at(grip.x, 2.58f, grip.z) * turned(30.0f * static_cast<float>(i), {0, 0, 1}));
  }
  return model;
}

Model bearer(const Palette& palette) {
  Model model{"bearer", {}};
  append(model.in(palette.marble),
         sculpt(
             [](vec3 p) {
               float d = body(p);
               for (const float side : {-1.0f, 1.0f}) {
                 d = blend(
                     d,
                     arm(p, {side * 0.235f, 1.735f, 0}, {side * 0.43f, 1.93f, 0.10f}, {side * 0.29f, 2.22f, 0.17f}),
                     0.04f);
               }
               return d;
             },
             {-0.60f, -0.03f, -0.48f}, {0.60f, 2.42f, 0.56f}, kFigureCell));
  append(model.in(palette.marble), head_piece());
  append(model.in(palette.gold),
         turned_vessel({{0, 2.29f},
                        {0.14f, 2.295f},
                        {0.16f, 2.31f},
                        {0.30f, 2.36f},
                        {0.40f, 2.46f},
                        {0.385f, 2.465f},
                        {0.28f, 2.385f},
                        {0, 2.34f}},
                       48, 4),
         at(0, 0, 0.17f));
  return model;
}

// Lying, 2.3 m from paws to tail, with a human head.
Model sphinx(const Palette& palette) {
  Model model{"sphinx", {}};
  append(model.in(palette.sandstone),
         sculpt(
             [](vec3 p) {
               vec3 m(std::abs(p.x), p.y, p.z);  // both sides are alike
               float d = capsule(p, {0, 0.42f, -0.75f}, {0, 0.52f, 0.32f}, 0.27f, 0.29f);
               d = blend(d, ellipsoid(p, {0, 0.62f, 0.40f}, {0.27f, 0.36f, 0.26f}), 0.15f);       // chest
               d = blend(d, ellipsoid(m, {0.21f, 0.30f, -0.72f}, {0.16f, 0.30f, 0.36f}), 0.08f);  // haunch
               d = blend(d, capsule(m, {0.27f, 0.09f, -0.95f}, {0.30f, 0.08f, -0.28f}, 0.10f, 0.085f),
                         0.06f);  // hind leg
               d = blend(d, capsule(m, {0.22f, 0.55f, 0.38f}, {0.23f, 0.14f, 0.42f}, 0.15f, 0.11f),
                         0.10f);  // shoulder
               d = blend(d, capsule(m, {0.23f, 0.10f, 0.40f}, {0.23f, 0.09f, 1.08f}, 0.105f, 0.095f),
                         0.06f);  // foreleg
               for (int toe = -1; toe <= 1; ++toe) {
                 d = blend(d,
                           capsule(m, {0.23f + 0.062f * static_cast<float>(toe), 0.075f, 1.06f},
                                   {0.23f + 0.066f * static_cast<float>(toe), 0.055f, 1.20f}, 0.045f, 0.040f),
                           0.02f);
               }
               for (int i = 0; i < 10; ++i) {  // the tail about the left haunch
                 const float a = 0.28f * static_cast<float>(i), b = a + 0.28f;
                 const auto on_tail = [](float s) {
                   return vec3(0.47f * std::sin(s), 0.09f, -0.72f - 0.42f * std::cos(s));
                 };
                 d = blend(d, capsule(p, on_tail(a), on_tail(b), 0.045f, 0.042f), 0.03f);
               }
               d = blend(d, capsule(p, {0, 0.70f, 0.42f}, {0, 1.08f, 0.46f}, 0.20f, 0.13f), 0.10f);
               return std::max(d, -p.y);
             },
             {-0.66f, -0.04f, -1.28f}, {0.66f, 1.30f, 1.30f}, 0.044f));
  append(model.in(palette.sandstone), head_piece(), at(0, -1.98f, 0.47f) * scaled(1.55f));
  return model;
}

Model plinth(const Palette& palette, float width, float height) {
  Model model{"plinth", {}};
  Mesh& stone = model.in(palette.granite);
  const float w = 0.5f * width;
  append(stone, bevel_box({-w - 0.07f, -0.02f, -w - 0.07f}, {w + 0.07f, 0.14f, w + 0.07f}, 0.02f));
  append(stone, bevel_box({-w, 0.13f, -w}, {w, height - 0.09f, w}, 0.015f));
  append(stone,
         bevel_box({-w - 0.03f, height - 0.13f, -w - 0.03f}, {w + 0.03f, height - 0.085f, w + 0.03f}, 0.012f));
  append(stone, bevel_box({-w - 0.06f, height - 0.09f, -w - 0.06f}, {w + 0.06f, height, w + 0.06f}, 0.02f));
  append(model.in(palette.gold),
         bevel_box({-0.7f * w, 0.30f * height, w - 0.02f}, {0.7f * w, 0.62f * height, w + 0.012f}, 0.006f));
  return model;
}

}  // namespace gnomon::scenes::assets::temple
