#include "daemon/render/render_session.h"

#include <algorithm>

namespace gnomon::daemon {
namespace {

// A frame of a scene of which nothing is known is cut from this size on: some 256x170 pixels under three lights.
constexpr uint64_t kUnknownBits = 1 << 17;

scheduler::Work work_of(const SessionQuality& quality, const TileRows& rows, bool begins) {
  const TileGrid grid = quality.grid();
  const uint32_t top = rows.first * kTileSize;
  const uint32_t bottom = std::min(rows.end() * kTileSize, grid.height);
  const uint64_t pixels = uint64_t{grid.width} * grid.height;
  return {pixels, quality.traced_bits(uint64_t{grid.width} * (bottom - top)), begins};
}

}  // namespace

NextJob next_job(const RenderSession& session, const scheduler::CostModel& model, Nanoseconds quantum,
                 uint64_t most_bits) {
  const TileGrid grid = session.quality.grid();
  const uint32_t first = session.partial ? session.partial->next_row : 0;
  const auto quantum_share = [&](double share) {
    return Nanoseconds(static_cast<int64_t>(share * static_cast<double>(quantum.count())));
  };
  const auto piece = [&](uint32_t rows) {
    NextJob job{{first, rows}, work_of(session.quality, {first, rows}, !session.partial), {}, {}, {}};
    const scheduler::Cost predicted = model.predict(job.work);
    const double worst = static_cast<double>(job.work.bits) / static_cast<double>(std::max<uint64_t>(1, most_bits));
    job.cost = session.view.apply(predicted);
    job.booked = std::max(job.cost, quantum_share(worst / 4));
    if (model.knows()) job.model_cost = predicted;
    return job;
  };
  const uint32_t remaining = grid.tiles_y() - first, fewest = session.partial ? 1 : 0;
  const NextJob all = piece(remaining);
  const Nanoseconds most = quantum / kJobsOfAQuantum;
  if (quantum <= Nanoseconds{} || remaining == 1) return all;
  if (!model.knows() && all.work.bits >= kUnknownBits) {
    // A row tells how many fit a piece; until then it counts as much as one, so that few are under way.
    NextJob row = piece(1);
    row.booked = std::max(row.booked, most);
    return row;
  }
  const uint64_t bits_of_row = std::max<uint64_t>(1, work_of(session.quality, {first, 1}, false).bits);
  const auto most_rows = static_cast<uint32_t>(std::clamp<uint64_t>(most_bits / bits_of_row, 1, remaining));
  // A frame that costs little more than a piece is not cut: each cut may make it wait for others' pieces.
  if (all.cost <= most + most / 2 && most_rows == remaining) return all;
  const Nanoseconds least = piece(fewest).cost;
  const double a_row = to_seconds(all.cost - least) / (remaining - fewest);
  const double fit = fewest + std::max(0.0, to_seconds(most - least) / a_row);
  const auto rows = static_cast<uint32_t>(std::clamp<double>(fit, fewest, most_rows));
  if (rows == 0) return piece(0);
  const uint32_t pieces = (remaining + rows - 1) / rows;
  return piece((remaining + pieces - 1) / pieces);  // of equal size
}

}  // namespace gnomon::daemon
