// Counts over a workgroup of 64, then over the frame.
//
// A pass binds statistics, whose first words are counted here.

// How many pixels could tell a suspicion from what was given, in how many of these what was given holds, and in how many the
// suspicion does: three words each, those of include/check_geometry first, then those of include/check_motion.
const SUSPICION_WORDS = 3u;
const FIRST_MOTION = SUSPICION_WORDS * GEOMETRY_SUSPICIONS;
const FIRST_LIGHT = FIRST_MOTION + SUSPICION_WORDS * MOTION_SUSPICIONS;
const FIRST_REFLECTION = FIRST_LIGHT + LIGHT_WORDS;
const STATISTICS = FIRST_REFLECTION + REFLECTION_WORDS;

var<workgroup> tallies: array<atomic<u32>, STATISTICS>;

fn clear_tallies(lane: u32) {
    for (var word = lane; word < STATISTICS; word += 64u) {
        atomicStore(&tallies[word], 0u);
    }
}

fn tally(word: u32, is_so: bool) {
    if is_so {
        atomicAdd(&tallies[word], 1u);
    }
}

fn vote(first: u32, suspicion: u32, given_holds: bool, suspicion_holds: bool) {
    let word = first + SUSPICION_WORDS * suspicion;
    tally(word, true);
    tally(word + 1u, given_holds);
    tally(word + 2u, suspicion_holds);
}

fn leave_tallies(lane: u32) {
    for (var word = lane; word < STATISTICS; word += 64u) {
        let count = atomicLoad(&tallies[word]);
        if count != 0u {
            atomicAdd(&statistics[word], count);
        }
    }
}
