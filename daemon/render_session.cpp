#include "daemon/render_session.h"

#include <algorithm>
#include <cmath>

namespace gnomon::daemon {
namespace {

scheduler::Work work_of(const TileGrid& grid, const TileRows& rows) {
  const uint32_t top = rows.first * kTileSize;
  const uint32_t bottom = std::min(rows.end() * kTileSize, grid.height);
  const uint64_t pixels = uint64_t{grid.width} * grid.height;
  return {pixels, uint64_t{grid.width} * (bottom - top) * grid.lights, rows.first == 0};
}

uint32_t shrunk(uint32_t side, double share) {
  if (share >= 1) return side;
  return std::max(kTileSize, static_cast<uint32_t>(side * share) / kTileSize * kTileSize);
}

}  // namespace

TileGrid RenderSession::wanted_grid() const {
  const double size = degradation.point().size;
  return {shrunk(granted_width, size), shrunk(granted_height, size), opened.lights};
}

NextJob next_job(const RenderSession& session, const scheduler::CostModel& model, Nanoseconds slice) {
  const TileGrid grid = session.grid();
  const uint32_t first = session.begun ? session.begun->next_row : 0;
  const auto piece = [&](uint32_t rows) {
    NextJob job{{first, rows}, work_of(grid, {first, rows}), {}, {}};
    const Nanoseconds predicted = model.predict(job.work);
    job.cost = session.view.apply(predicted);
    if (model.knows()) job.model_cost = predicted;
    return job;
  };
  const uint32_t remaining = grid.tiles_y() - first;
  const NextJob all = piece(remaining);
  const Nanoseconds most = slice / kJobsOfASlice;
  if (slice <= Nanoseconds{} || all.cost <= most || remaining == 1) return all;
  const Nanoseconds one_row = piece(1).cost;
  const double a_row = to_seconds(all.cost - one_row) / (remaining - 1);
  const double fit = 1 + std::max(0.0, to_seconds(most - one_row) / a_row);
  const auto rows = static_cast<uint32_t>(std::clamp(fit, 1.0, static_cast<double>(remaining)));
  const uint32_t pieces = (remaining + rows - 1) / rows;
  return piece((remaining + pieces - 1) / pieces);  // of equal size
}

}  // namespace gnomon::daemon
