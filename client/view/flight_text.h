// What gnomon-client prints of a flight that has ended.
#pragma once

#include "client/view/flight.h"
#include "common/sample_counts.h"

namespace gnomon::client {

void print_figures(const FlightStats& figures);
// Of what was wanted beyond hard shadows, how much the server granted.
void print_granted(SampleCounts wanted, SampleCounts granted);

}  // namespace gnomon::client
