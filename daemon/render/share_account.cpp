#include "daemon/render/share_account.h"

#include <algorithm>
#include <cmath>

namespace gnomon::daemon {

void ShareAccount::set_sharing(const SharingPolicy& sharing) {
  tenants_.resize(std::max(tenants_.size(), sharing.tenants.size()));
  for (size_t i = 0; i < sharing.tenants.size(); ++i) {
    Tenant& tenant = tenants_[i];
    tenant.weight = sharing.tenants[i].scheduling.weight;
    if (tenant.rates == sharing.tenants[i].rates) continue;  // what was spent stays spent
    // What was spent at a rate that was perhaps a mistake must not outlive it.
    tenant.rates = sharing.tenants[i].rates;
    tenant.buffers = tenant.bits = tenant.bytes = tenant.gpu = scheduler::RateLimit(0, kBurst);
    set_rates(tenant);
  }
}

// What was spent before stays spent.
void ShareAccount::set_rates(Tenant& tenant) {
  tenant.buffers.set(tenant.fraction * tenant.rates.buffers_per_second);
  tenant.bits.set(tenant.fraction * tenant.rates.bits_per_second);
  tenant.bytes.set(tenant.fraction * tenant.rates.bytes_per_second);
  tenant.gpu.set(tenant.fraction * tenant.rates.gpu_share);
}

// A fraction of 0 is ignored: it would mean no limit, and no session needs one.
void ShareAccount::set_fraction(TenantId id, double fraction) {
  if (fraction <= 0) return;
  tenants_.resize(std::max<size_t>(tenants_.size(), id.value + 1));
  Tenant& tenant = tenants_[id.value];
  tenant.fraction = fraction;
  set_rates(tenant);
}

void ShareAccount::sample_backlog() {
  for (Tenant& tenant : tenants_) tenant.always_busy &= tenant.waiting > 0;
}

void ShareAccount::started(TenantId id, bool begins_frame, uint64_t bits, TimePoint now) {
  Tenant& tenant = tenants_[id.value];
  if (begins_frame) tenant.buffers.spend(1, now);
  tenant.bits.spend(static_cast<double>(bits), now);
}

void ShareAccount::sent(TenantId id, size_t bytes, TimePoint now) {
  tenants_[id.value].bytes.spend(static_cast<double>(bytes), now);
}

void ShareAccount::finished(TenantId id, Nanoseconds predicted, Nanoseconds real, TimePoint now) {
  Tenant& tenant = tenants_[id.value];
  tenant.service += real;
  tenant.recent += real;
  tenant.gpu.spend(to_seconds(real), now);
  if (real <= Nanoseconds{}) return;
  tenant.errors += std::abs(to_seconds(predicted - real)) / to_seconds(real);
  ++tenant.jobs;
}

TimePoint ShareAccount::eligible_at(TenantId id) const {
  const Tenant& tenant = tenants_[id.value];
  return std::max({tenant.buffers.eligible_at(), tenant.bits.eligible_at(), tenant.bytes.eligible_at(),
                   tenant.gpu.eligible_at()});
}

ShareReport ShareAccount::report(const scheduler::Scheduler& policy) {
  ShareReport report;
  Nanoseconds all{};
  double weights = 0, sum = 0, squares = 0;
  int busy = 0;
  for (const Tenant& tenant : tenants_) {
    all += tenant.recent;
    if (!tenant.always_busy) continue;
    const double by_weight = to_seconds(tenant.recent) / tenant.weight;
    ++busy;
    weights += tenant.weight;
    sum += by_weight;
    squares += by_weight * by_weight;
  }
  if (busy > 1 && squares > 0) report.jain = sum * sum / (busy * squares);
  for (uint32_t i = 0; i < tenants_.size(); ++i) {
    Tenant& tenant = tenants_[i];
    TenantReport row;
    row.service = tenant.service;
    row.share = all.count() > 0 ? to_seconds(tenant.recent) / to_seconds(all) : 0;
    row.expected_share = tenant.always_busy ? tenant.weight / weights : 0;
    row.lag = policy.standing(TenantId{i}).lag;
    row.predicted_error = tenant.jobs > 0 ? tenant.errors / static_cast<double>(tenant.jobs) : 0;
    report.worst_lag = std::max({report.worst_lag, row.lag, -row.lag});
    report.tenants.push_back(row);
    tenant.recent = {};
    tenant.errors = 0;
    tenant.jobs = 0;
    tenant.always_busy = tenant.waiting > 0;
  }
  return report;
}

}  // namespace gnomon::daemon
