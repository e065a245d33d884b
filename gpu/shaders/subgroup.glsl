// What the LANES lanes of a subgroup tell each other. One workgroup is one subgroup.
//
// With EMULATED_SUBGROUP the invocations of the workgroup stand for the lanes, and exchange their votes through shared
// memory: with it, tests run the shaders for subgroups that no device at hand has. Every lane must then reach each call.
#ifdef EMULATED_SUBGROUP

shared uint subgroup_votes[4];

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

#else
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require

uint lane() { return gl_SubgroupInvocationID; }

// A bit for each lane, 32 in each component.
uvec4 ballot(bool vote) { return subgroupBallot(vote); }

bool any_lane(bool vote) { return subgroupAny(vote); }

#endif
