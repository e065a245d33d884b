// What is asked of a footprint all at once, for four quarters or six faces, is what is asked of each by itself.
#include "gpu/tracers/light_buffer/footprint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/gpu/light_buffer/soups.h"

namespace gnomon::test {
namespace {

namespace light_buffer = gpu::light_buffer;
using light_buffer::Face;
using light_buffer::Footprint;
using light_buffer::Rect;

struct Counts {
  size_t met = 0, missed = 0, hidden = 0;
};

// The squares of `face` that hold the middle of what it shows of the footprint, level by level, and one beside each.
void compare_quarters(const Face& face, const Footprint& f, Random& random, Counts& counts) {
  const Rect part = light_buffer::common(f.box, face.square(0, 0, 0));
  const auto index = [&](double place, double low, uint32_t level) {
    const double side = face.size * light_buffer::power_of_two(-static_cast<int>(level));
    const auto last = static_cast<double>((1u << level) - 1);
    return static_cast<uint32_t>(std::clamp((place - low) / side, 0.0, last));
  };
  for (uint32_t level = 0; level < 9; ++level) {
    const uint32_t last = (1u << level) - 1;
    const uint32_t i = std::min<uint32_t>(last, index(0.5 * (part.u0 + part.u1), face.low_u, level) + random() % 2);
    const uint32_t j = std::min<uint32_t>(last, index(0.5 * (part.v0 + part.v1), face.low_v, level) + random() % 2);
    const light_buffer::Quarters quarters(face.square(level + 1, 2 * i, 2 * j),
                                          face.square(level + 1, 2 * i + 1, 2 * j + 1));
    const uint32_t met = light_buffer::quarters_met(f, quarters);
    for (uint32_t c = 0; c < 4; ++c) {
      const bool expected = light_buffer::meets(f, face.square(level + 1, 2 * i + (c & 1), 2 * j + (c >> 1)));
      EXPECT_EQ((met >> c & 1) != 0, expected) << "level " << level << " quarter " << c;
      ++(expected ? counts.met : counts.missed);
    }
  }
}

// Whether the face shows one of some points of the triangle.
bool shows_points(const Face& face, const std::array<glm::dvec3, 3>& corners, Random& random) {
  std::uniform_real_distribution<double> share(0.0, 1.0);
  for (int point = 0; point < 20; ++point) {
    double u = share(random), v = share(random);
    if (u + v > 1.0) u = 1.0 - u, v = 1.0 - v;
    const glm::dvec3 p = face.to_face(corners[0] + u * (corners[1] - corners[0]) + v * (corners[2] - corners[0]));
    if (p.z > 0.0 && std::abs(p.x) <= p.z && std::abs(p.y) <= p.z) return true;
  }
  return false;
}

class Footprints : public testing::TestWithParam<Shape> {};

TEST_P(Footprints, AreAskedForQuartersAndFacesAtOnceAsForEach) {
  Random random(static_cast<uint32_t>(GetParam()) + 1);
  Counts counts;
  for (int scene = 0; scene < 8 && !HasFailure(); ++scene) {
    const Soup soup = make_soup(GetParam(), Lamp::point, 60, random);
    const double radius = scene % 2 == 0 ? 0.0 : 0.3;
    const light_buffer::LightFaces faces = light_buffer::light_faces(soup.light, soup.bounds);
    for (const glm::uvec3& t : soup.mesh.triangles) {
      std::array<glm::dvec3, 3> corners;
      for (int k = 0; k < 3; ++k)
        corners[static_cast<size_t>(k)] = glm::dvec3(soup.mesh.positions[t[k]]) - faces.reference;
      const uint32_t met = light_buffer::faces_met(faces.diameter, radius, corners);
      for (size_t f = 0; f < faces.faces.size(); ++f) {
        const Face& face = faces.faces[f];
        if ((met >> f & 1) == 0) {
          EXPECT_FALSE(shows_points(face, corners, random));
          ++counts.hidden;
        } else if (radius > 0.0) {
          if (const auto made = light_buffer::area_footprint(face, faces.diameter, radius, corners))
            compare_quarters(face, *made, random, counts);
        } else if (const auto made = light_buffer::footprint(face, faces.diameter, corners)) {
          compare_quarters(face, *made, random, counts);
        }
      }
    }
  }
  EXPECT_GT(counts.met, 1000u);
  if (GetParam() == Shape::even || GetParam() == Shape::tiny) {
    EXPECT_GT(counts.missed, 100u);
    EXPECT_GT(counts.hidden, 1000u);
  }
}

INSTANTIATE_TEST_SUITE_P(Soups, Footprints,
                         testing::Values(Shape::even, Shape::tiny, Shape::huge, Shape::slivers, Shape::edge_on,
                                         Shape::touching, Shape::sheets, Shape::astride, Shape::around,
                                         Shape::grid),
                         [](const auto& soup) { return name(soup.param); });

}  // namespace
}  // namespace gnomon::test
