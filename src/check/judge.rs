//! From numbers to sentences.

use super::cameras::Cameras;
use super::evidence::{Evidence, Votes, octaves};
use super::suspicion::{GEOMETRY, MOTION, Suspicion};
use super::{Finding, Mistake, Untold};

/// Fewer pixels that could tell, over all frames, tell nothing.
const LEAST_PIXELS: u64 = 500;
/// Nor do fewer frames.
const LEAST_FRAMES: u32 = 3;
/// A suspicion explains at least this share of the pixels that can tell: all but what moves on its own, or is bumpy.
const LEAST_MEANT: f64 = 0.6;
/// And what was given at most this share: if it were right, it would explain most of them.
const MOST_GIVEN: f64 = 0.25;
/// Shares that close are equal; the earlier, simpler suspicion is said.
const EQUAL: f64 = 0.02;

/// Which of the optional inputs came.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Given {
    pub ids: bool,
    pub emission: bool,
    pub hit_distance: bool,
}

/// Everything that looks wrong, the most fundamental first.
pub(super) fn findings(evidence: &Evidence, cameras: &Cameras) -> Vec<Finding> {
    let mut found = camera_findings(cameras);
    let (of_geometry, of_motion) = evidence.votes.split_at(GEOMETRY.len());
    let geometry = best(&GEOMETRY, of_geometry);
    let motion = best(&MOTION, of_motion);
    let says = |found: &[Finding], mistake| found.iter().any(|finding: &Finding| finding.mistake == mistake);
    let is_camera =
        |found: &Option<Finding>| found.as_ref().is_some_and(|f| f.mistake == Mistake::CameraTransposed);
    if is_camera(&motion) {
        found.extend(motion);
    } else if is_camera(&geometry) {
        found.extend(geometry);
    } else {
        // Motion is judged by depth and matrices: what is wrong with these has to be known first.
        let depth_holds = geometry.as_ref().is_none_or(|finding| finding.input != "depth");
        let jitter = says(&found, Mistake::JitterInMatrices);
        found.extend(geometry);
        found.extend(motion.filter(|f| depth_holds && !(jitter && f.mistake == Mistake::JitterInMotion)));
    }
    let of_images = [depth_sign, albedo_missing, albedo_encoded, emission, ids, hit_distances];
    found.extend(of_images.iter().filter_map(|judge| judge(evidence)));
    found
}

fn finding(input: &'static str, mistake: Mistake, sentence: String) -> Finding {
    Finding { input, mistake, sentence }
}

fn camera_findings(cameras: &Cameras) -> Vec<Finding> {
    let mut found = Vec::new();
    let matrices =
        [("view_from_world", cameras.transposed.view), ("clip_from_view", cameras.transposed.projection)];
    for (matrix, frames) in matrices.into_iter().filter(|&(_, frames)| frames > 0) {
        let sentence = format!(
            "`camera`: `{matrix}` seems to be transposed: the denoiser refuses it as given in {frames} frames and would \
             take it transposed; matrices are for column vectors, with translation in the last column"
        );
        found.push(finding("camera", Mistake::CameraTransposed, sentence));
    }
    if let Some(step) = cameras.jitter() {
        let sentence = format!(
            "`camera`: `clip_from_view` seems to hold jitter: its centre steps by {step:.2} pixels a frame, back and forth; \
             give matrices without jitter, and the jitter as `jitter_px`"
        );
        found.push(finding("camera", Mistake::JitterInMatrices, sentence));
    }
    found
}

/// The suspicion that explains most, where what was given does not.
fn best(suspicions: &[Suspicion], votes: &[Votes]) -> Option<Finding> {
    let clear = |(_, votes): &(&Suspicion, &Votes)| {
        votes.told >= LEAST_PIXELS
            && votes.frames >= LEAST_FRAMES
            && votes.meant_share() >= LEAST_MEANT
            && votes.given_share() <= MOST_GIVEN
    };
    let clear: Vec<_> = suspicions.iter().zip(votes).filter(clear).collect();
    let most = clear.iter().map(|(_, votes)| votes.meant_share()).fold(0.0, f64::max);
    let (suspicion, votes) = clear.into_iter().find(|(_, votes)| votes.meant_share() >= most - EQUAL)?;
    let (given, meant) = (100.0 * votes.given_share(), 100.0 * votes.meant_share());
    let Suspicion { input, mistake, seems, advice, .. } = *suspicion;
    let sentence = format!(
        "`{input}` seems to {seems}: read so, {meant:.0} % of {} pixels that tell agree with the other inputs, as given \
         {given:.0} %; {advice}",
        votes.told
    );
    Some(finding(input, mistake, sentence))
}

/// Of the pixels, those that hold a negative depth, if z in view space was given.
const MOSTLY: f64 = 0.5;

fn depth_sign(evidence: &Evidence) -> Option<Finding> {
    let (pixels, negative) = (evidence.light("PIXELS"), evidence.light("DEPTH_NEGATIVE"));
    let is_wrong = negative >= LEAST_PIXELS && negative as f64 > MOSTLY * pixels as f64;
    is_wrong.then(|| {
        let share = 100.0 * negative as f64 / pixels as f64;
        let sentence = format!(
            "`depth` seems to be the z coordinate in view space: it is negative in {share:.0} % of {pixels} pixels, which \
             are taken for misses; negate it"
        );
        finding("depth", Mistake::DepthNegative, sentence)
    })
}

/// Of the hits, those that have the same, extreme albedo, if there is none.
const ALL_BUT_FEW: f64 = 0.995;

fn albedo_missing(evidence: &Evidence) -> Option<Finding> {
    let hits = evidence.light("HITS");
    let all = |name| evidence.light(name) as f64 > ALL_BUT_FEW * hits as f64;
    let value = if all("ALBEDO_ONE") { 1 } else { 0 };
    (hits >= LEAST_PIXELS && (all("ALBEDO_ONE") || all("ALBEDO_ZERO"))).then(|| {
        let sentence = format!(
            "`albedo` seems to be missing: it is {value} at nearly all of {hits} hits; give the diffuse reflectance of first \
             hits, or textures will be blurred"
        );
        finding("albedo", Mistake::AlbedoMissing, sentence)
    })
}

/// Pixels times variance of log albedo below which noise decides.
const LEAST_TEXTURE: f64 = 100.0;
/// Radiance over albedo to this power more is sRGB: it would be 1.2 without gloss, which only lowers it.
const LEAST_SLOPE: f64 = 0.4;
/// Standard errors between the slope and 0.
const SIGNIFICANT: f64 = 4.0;

fn albedo_encoded(evidence: &Evidence) -> Option<Finding> {
    let [given, decoded] = &evidence.slopes;
    let (slope, error) = (given.value(), given.error()?);
    let is_wrong = given.weight() > LEAST_TEXTURE
        && slope > LEAST_SLOPE
        && slope > SIGNIFICANT * error
        && decoded.value().abs() < 0.5 * slope;
    is_wrong.then(|| {
        let sentence = format!(
            "`albedo` seems to be encoded as sRGB: on textured surfaces radiance goes with its power {:.2}, decoded with \
             {:.2}, expected is 1; use an `Srgb` format or decode it to linear",
            1.0 + slope,
            1.0 + decoded.value(),
        );
        finding("albedo", Mistake::AlbedoNotLinear, sentence)
    })
}

/// Emission is known without noise.
const LEAST_EMITTERS: u64 = 100;
/// Of pixels that emit, those that may differ from the rest.
const FEW: f64 = 0.05;

fn emission(evidence: &Evidence) -> Option<Finding> {
    let emitters = evidence.light("EMITTERS");
    let share = |name| evidence.light(name) as f64 / emitters.max(1) as f64;
    if emitters < LEAST_EMITTERS {
        return None;
    }
    if share("EMISSION_TWICE") > MOSTLY && share("EMISSION_LESS") < FEW {
        let sentence = format!(
            "`radiance` seems to hold emission twice: in {:.0} % of {emitters} pixels that emit it is twice `emission`, \
             hardly anywhere less; add emission once, and give the same in both",
            100.0 * share("EMISSION_TWICE"),
        );
        return Some(finding("emission", Mistake::EmissionTwice, sentence));
    }
    (share("EMISSION_LACKING") > MOSTLY).then(|| {
        let sentence = format!(
            "`radiance` seems to lack emission: in {:.0} % of {emitters} pixels that emit it is less than `emission`; \
             radiance includes what is seen directly",
            100.0 * share("EMISSION_LACKING"),
        );
        finding("emission", Mistake::EmissionLacking, sentence)
    })
}

/// Of surfaces found again by motion, depth and normal, those with the same id, if ids are made anew each frame.
const SAME_BY_CHANCE: f64 = 0.1;

fn ids(evidence: &Evidence) -> Option<Finding> {
    let (found, same) = (evidence.light("IDS_FOUND"), evidence.light("IDS_SAME"));
    let is_wrong = found >= LEAST_PIXELS && (same as f64) < SAME_BY_CHANCE * found as f64;
    is_wrong.then(|| {
        let share = 100.0 * same as f64 / found as f64;
        let sentence = format!(
            "`surface_id` seems to change from frame to frame: of {found} surfaces that motion, depth and normal find \
             again, {share:.0} % have the id that they had; ids must stay, or history is lost"
        );
        finding("surface_id", Mistake::IdsChange, sentence)
    })
}

/// Share of reflected rays that meet something about as far away as told, if the unit is right.
const LEAST_RIGHT: f64 = 0.2;

fn hit_distances(evidence: &Evidence) -> Option<Finding> {
    let (met, along, ratios) = evidence.reflected();
    let share = |count: u64| count as f64 / met.max(1) as f64;
    let pair = |first: usize| share(ratios[first] + ratios[first + 1]);
    let middle = ratios.len() / 2;
    let right = share(ratios[middle - 1..=middle + 1].iter().sum());
    if met < LEAST_PIXELS || right > LEAST_RIGHT {
        return None;
    }
    if share(along) > MOSTLY {
        let sentence = format!(
            "`hit_distance` seems to be measured from the eye: of {met} reflected rays that meet something on the screen, \
             {:.0} % agree so, as given {:.0} %; give the distance from the first hit",
            100.0 * share(along),
            100.0 * right,
        );
        return Some(finding("hit_distance", Mistake::HitDistanceFromEye, sentence));
    }
    let first = (0..ratios.len() - 1).max_by(|&a, &b| pair(a).total_cmp(&pair(b)))?;
    (pair(first) > MOSTLY).then(|| {
        let (low, high) = (ratios[first] as f64, ratios[first + 1] as f64);
        // Known to a few per cent: two digits.
        let factor = octaves(first as f64 + high / (low + high)).exp2();
        let digit = 10f64.powf(factor.log10().floor() - 1.0);
        let factor = (factor / digit).round() * digit;
        let sentence = format!(
            "`hit_distance` seems to be in another unit: about {} times what {met} reflected rays meet on the \
             screen, in {:.0} % of them, about right in {:.0} %; give it in the unit of the scene",
            factor as f32,
            100.0 * pair(first),
            100.0 * right,
        );
        finding("hit_distance", Mistake::HitDistanceUnit, sentence)
    })
}

/// What there was too little of to judge, of what was given.
pub(super) fn untold(evidence: &Evidence, cameras: &Cameras, given: Given) -> Vec<Untold> {
    let told = |votes: &Votes| votes.told >= LEAST_PIXELS && votes.frames >= LEAST_FRAMES;
    let vote = |name: &str| {
        let named = GEOMETRY.iter().chain(&MOTION).position(|suspicion| suspicion.name == name);
        named.is_some_and(|place| told(&evidence.votes[place]))
    };
    let is_flat = vote("NORMAL_INVERTED");
    let moves = vote("MOTION_BACKWARDS");
    let reasons = [
        (is_flat, "normal_roughness", "no flat surfaces were seen"),
        (
            !is_flat || vote("NORMAL_VIEW_SPACE") || vote("NORMAL_WORLD_SPACE"),
            "normal_roughness",
            "view space and world space did not differ enough",
        ),
        (
            vote("DEPTH_HARDWARE") || vote("DEPTH_LINEAR"),
            "depth",
            "no flat surfaces were seen that do not face the camera",
        ),
        (moves, "motion", "the camera stood still"),
        (
            !moves || vote("CAMERA_LATE"),
            "camera",
            "it moved too evenly to tell whether it comes a frame late",
        ),
        (
            !cameras.declared_jitter || vote("MOTION_JITTERED"),
            "motion",
            "jitter hardly changed, so it cannot be told whether motion holds it",
        ),
        (
            evidence.slopes[0].weight() > LEAST_TEXTURE,
            "albedo",
            "too little texture on rough surfaces to tell whether it is linear",
        ),
        (
            !given.ids || evidence.light("IDS_FOUND") >= LEAST_PIXELS,
            "surface_id",
            "no surface was found again in the next frame",
        ),
        (!given.emission || evidence.light("EMITTERS") >= LEAST_EMITTERS, "emission", "no emitter was seen"),
        (
            !given.hit_distance || evidence.reflected().0 >= LEAST_PIXELS,
            "hit_distance",
            "no smooth surface showed what is on the screen",
        ),
    ];
    reasons
        .into_iter()
        .filter(|(is_told, ..)| !is_told)
        .map(|(_, input, reason)| Untold { input, reason })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::suspicion::{STATISTICS, SUSPICION_WORDS};

    /// Of so many frames, in each of which so many pixels tell of a suspicion, by these shares.
    fn found(name: &str, frames: u32, pixels: u32, given: f32, meant: f32) -> Vec<Mistake> {
        let place = GEOMETRY.iter().chain(&MOTION).position(|suspicion| suspicion.name == name).unwrap();
        let mut words = [0; STATISTICS];
        let share = |share: f32| (share * pixels as f32) as u32;
        words[SUSPICION_WORDS * place..][..SUSPICION_WORDS].copy_from_slice(&[
            pixels,
            share(given),
            share(meant),
        ]);
        let mut evidence = Evidence::default();
        (0..frames).for_each(|_| evidence.add(&words));
        findings(&evidence, &Cameras::default()).iter().map(|finding| finding.mistake).collect()
    }

    #[test]
    fn only_what_is_clear_is_said() {
        let name = "MOTION_BACKWARDS";
        assert_eq!(found(name, 4, 1000, 0.02, 0.97), [Mistake::MotionSign]);
        assert_eq!(found(name, 2, 1000, 0.02, 0.97), [], "too few frames");
        assert_eq!(found(name, 4, 100, 0.02, 0.97), [], "too few pixels");
        assert_eq!(found(name, 4, 1000, 0.02, 0.40), [], "most things move on their own");
        assert_eq!(found(name, 4, 1000, 0.39, 0.60), [], "what was given holds, too");
    }

    #[test]
    fn words_of_another_length_are_left_alone() {
        let mut evidence = Evidence::default();
        evidence.add(&[7; 3]);
        assert_eq!(evidence, Evidence::default());
    }
}
