#include "daemon/encode/encode_pool.h"

#include <algorithm>
#include <utility>

#include "common/log.h"
#include "common/within_memory.h"

namespace gnomon::daemon {

EncodePool::EncodePool(uint32_t threads, std::vector<Cores> near, Metrics& metrics, FrameSink& sink)
    : near_(std::move(near)), metrics_(metrics), sink_(sink) {
  const bool known = std::any_of(near_.begin(), near_.end(), [](const Cores& cores) { return !cores.empty(); });
  const bool own = known && threads >= near_.size();  // with fewer workers some device would have none
  for (uint32_t i = 0; i < threads; ++i) {
    const auto home = own ? std::optional(i % static_cast<uint32_t>(near_.size())) : std::nullopt;
    workers_.emplace_back([this, home] { work(home); });
  }
}

EncodePool::~EncodePool() {
  {
    std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  ready_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void EncodePool::push(RenderedFrame frame) {
  {
    std::lock_guard lock(mutex_);
    queue_.push_back(std::move(frame));
  }
  ready_.notify_one();
}

std::optional<EncodePool::Work> EncodePool::take(std::optional<uint32_t> home) {
  std::unique_lock lock(mutex_);
  for (;;) {
    ready_.wait(lock, [this] { return stopping_ || !queue_.empty() || !shared_.empty(); });
    if (stopping_) return std::nullopt;
    if (!shared_.empty()) {
      const SharedPtr shared = shared_.front();
      if (shared->next < shared->frame.unit_count()) return shared;
      shared_.pop_front();  // every unit has a worker
      continue;
    }
    auto next = std::find_if(queue_.begin(), queue_.end(),
                             [home](const RenderedFrame& f) { return !home || f.meta.route.device == *home; });
    if (next == queue_.end()) next = queue_.begin();
    Work frame = std::move(*next);
    queue_.erase(next);
    return frame;
  }
}

void EncodePool::work(std::optional<uint32_t> home) {
  if (const auto stays = home ? stay_on(near_[*home]) : Result<void>(); !stays) {
    log::warning("an encode worker stays near no device", {{"why", stays.error().message}});
  }
  protocol::FrameEncoder encoder;
  while (std::optional<Work> taken = take(home)) {
    if (RenderedFrame* frame = std::get_if<RenderedFrame>(&*taken)) {
      begin(*frame, encoder);
    } else {
      help(*std::get<SharedPtr>(*taken));
    }
  }
}

// Encodes the frame, or shares it with the workers that are idle.
void EncodePool::begin(RenderedFrame& frame, protocol::FrameEncoder& encoder) {
  if (frame.meta.spec.codec == protocol::CodecId::raw32_lz4) return encode(frame, encoder);
  const auto shared = within_memory([&]() -> Result<SharedPtr> { return share(frame); });
  if (shared) return help(**shared);
  frame.mask.drop();
  deliver({frame.meta, {}}, shared.error());
}

namespace {

size_t payload_room(const FrameMeta& meta) {
  return meta.spec.slice_body_bytes - protocol::kSliceHeaderBytes -
         (meta.spec.moment ? protocol::kMomentBytes : 0) - (meta.spec.tells_size ? protocol::kSizeBytes : 0) -
         (meta.spec.tells_samples ? protocol::kSamplesBytes : 0);
}

}  // namespace

void EncodePool::encode(RenderedFrame& frame, protocol::FrameEncoder& encoder) {
  EncodedFrame out{frame.meta, {}};
  out.meta.times.encode_began = Clock::now();
  const auto result = within_memory([&] {
    return encoder.encode(frame.mask.mask(), frame.meta.spec.codec, payload_room(frame.meta), out.slices);
  });
  frame.mask.drop();
  deliver(std::move(out), result);
}

EncodePool::SharedPtr EncodePool::share(RenderedFrame& frame) {
  const FrameSpec& spec = frame.meta.spec;
  const TimePoint began = Clock::now();
  const bool copies = spec.codec == protocol::CodecId::tiles_context;
  auto split = copies
                   ? protocol::SplitFrame::of_context(
                         frame.mask.mask(), payload_room(frame.meta),
                         spec.references ? spec.references->newest(spec.grid, spec.samples) : nullptr, spec.camera)
                   : protocol::SplitFrame::of_bands(frame.mask.mask(), payload_room(frame.meta));
  const SharedPtr shared(new Shared{{frame.meta, {}}, std::move(frame.mask), std::move(split), {}, {}});
  shared->out.meta.times.encode_began = began;
  if (copies) shared->mask.drop();
  const size_t units = shared->frame.unit_count();
  if (units == 0) finish(*shared);
  if (units > 1 && workers_.size() > 1) {
    {
      std::lock_guard lock(mutex_);
      shared_.push_back(shared);
    }
    for (size_t others = std::min(units, workers_.size()) - 1; others > 0; --others) ready_.notify_one();
  }
  return shared;
}

void EncodePool::help(Shared& shared) {
  const size_t units = shared.frame.unit_count();
  for (size_t unit = shared.next++; unit < units; unit = shared.next++) {
    const auto encoded = within_memory([&]() -> Result<void> {
      shared.frame.encode(unit);
      return {};
    });
    if (!encoded) shared.failed = true;
    if (++shared.done == units) finish(shared);
  }
}

void EncodePool::finish(Shared& shared) {
  const FrameMeta& meta = shared.out.meta;
  shared.mask.drop();
  const auto result = within_memory([&]() -> Result<void> {
    if (shared.failed) throw std::bad_alloc();
    if (auto joined = shared.frame.join(shared.out.slices); !joined) return joined;
    if (meta.spec.references && meta.spec.codec == protocol::CodecId::tiles_context) {
      meta.spec.references->sent(
          std::make_shared<protocol::MaskReference>(meta.route.frame, shared.frame.decoded(), meta.spec.camera),
          meta.spec.samples);
    }
    return {};
  });
  deliver(std::move(shared.out), result);
}

void EncodePool::deliver(EncodedFrame out, const Result<void>& result) {
  out.meta.times.encoded = Clock::now();
  done_or_dropped("an encoded frame", [&] {
    if (result) return sink_.on_encoded(std::move(out));
    const FrameRoute& route = out.meta.route;
    metrics_.dropped(route.tenant, route.session, Fault::encode_failed, result.error().message);
  });
}

}  // namespace gnomon::daemon
