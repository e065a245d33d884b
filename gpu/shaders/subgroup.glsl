// What the LANES lanes of a subgroup tell each other. One workgroup is one subgroup.
//
// With EMULATED_SUBGROUP the invocations of the workgroup stand for the lanes, and exchange their votes through shared
// memory: with it, tests run the shaders for subgroups that no device at hand has. Every lane must then reach each call.
#ifdef EMULATED_SUBGROUP

shared uint subgroup_votes[4];
shared uvec3 subgroup_value;

uint lane() { return gl_LocalInvocationIndex; }

uvec4 ballot(bool vote) {
  barrier();  // because a lane may still be reading the votes of the ballot before
  if (lane() < 4u) subgroup_votes[lane()] = 0u;
  barrier();
  if (vote) atomicOr(subgroup_votes[lane() / 32u], 1u << (lane() % 32u));
  barrier();
  return uvec4(subgroup_votes[0], subgroup_votes[1], subgroup_votes[2], subgroup_votes[3]);
}

bool any_lane(bool vote) { return ballot(vote) != uvec4(0u); }

uint lowest_lane(uvec4 votes) {
  uint i = votes.x != 0u ? 0u : votes.y != 0u ? 1u : votes.z != 0u ? 2u : 3u;
  return 32u * i + uint(findLSB(votes[i]));
}

uvec3 broadcast(uvec3 value, uint from) {
  barrier();  // because a lane may still be reading the value before
  if (lane() == from) subgroup_value = value;
  barrier();
  return subgroup_value;
}

uint broadcast(uint value, uint from) { return broadcast(uvec3(value), from).x; }

vec3 broadcast(vec3 value, uint from) { return uintBitsToFloat(broadcast(floatBitsToUint(value), from)); }

#else
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require

uint lane() { return gl_SubgroupInvocationID; }

// A bit for each lane, 32 in each component.
uvec4 ballot(bool vote) { return subgroupBallot(vote); }

bool any_lane(bool vote) { return subgroupAny(vote); }

// Of a ballot in which some lane voted.
uint lowest_lane(uvec4 votes) { return subgroupBallotFindLSB(votes); }

// The value of lane `from`, which is the same in all lanes.
uint broadcast(uint value, uint from) { return subgroupBroadcast(value, from); }
vec3 broadcast(vec3 value, uint from) { return subgroupBroadcast(value, from); }

#endif

// How many lanes voted, and how many of them are before this one.
uint lanes_in(uvec4 votes) {
  uvec4 counts = uvec4(bitCount(votes));
  return counts.x + (LANES > 32 ? counts.y : 0u) + (LANES > 64 ? counts.z + counts.w : 0u);
}
uint lanes_before(uvec4 votes) {
  uint word = lane() / 32u, below = (1u << (lane() & 31u)) - 1u;
  uvec4 kept;
  for (uint i = 0u; i < 4u; ++i) kept[i] = i < word ? votes[i] : i == word ? votes[i] & below : 0u;
  return lanes_in(kept);
}
