//! Keeps a frame's time at a target by the number of models. Plain arithmetic on readings; where these come from is
//! `pacing`'s concern.

use std::collections::VecDeque;

/// Aimed at, as a share of the target: so that frames which take a few percent longer than most still keep it.
const AIM: f32 = 0.95;
/// A deviation from the aim that few readings tell, as a share of it.
const LARGE: f32 = 0.15;
/// Of so many readings the median counts: a single stall is not seen, nor are two.
const FEW: usize = 5;
/// A deviation that is left alone, which as many readings as are kept tell from noise.
const SMALL: f32 = 0.05;
const MANY: usize = 15;
/// Share of the limit below which a frame is taken to need no more models than it had.
const NEEDED: f32 = 0.9;

/// What a frame came to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reading {
    /// Number of the frame.
    pub frame: u32,
    pub ms: f32,
}

/// Chooses how many models frames may fit.
///
/// Time is a fixed part and a part per model, so it is at most proportional to their number: `models * aim / time` never
/// overshoots and approaches the aim from one side. Only readings of frames that had the present limit count, so that the
/// latency of readings cannot make it swing.
#[derive(Debug)]
pub(crate) struct Controller {
    least: u32,
    most: u32,
    limit: u32,
    /// The first frame that had this limit.
    since: u32,
    readings: VecDeque<f32>,
    /// Models of the newest frame since then.
    used: Option<u32>,
}

impl Controller {
    /// Starts with `limit` models at `frame`; it stays between `least`, which are always fitted, and `most`.
    pub fn new([least, most]: [u32; 2], limit: u32, frame: u32) -> Self {
        let limit = limit.clamp(least, most);
        Self { least, most, limit, since: frame, readings: VecDeque::new(), used: None }
    }

    /// Goes on in frames of another size, with as many models a pixel. Times of the old size say nothing of it.
    pub fn rescale(&mut self, [least, most]: [u32; 2], frame: u32) {
        let share = f64::from(most) / f64::from(self.most);
        *self = Self::new([least, most], (f64::from(self.limit) * share).round() as u32, frame);
    }

    /// Notes a time. Times that arrive twice or late do no harm.
    pub fn add_time(&mut self, Reading { frame, ms }: Reading) {
        if frame < self.since {
            return;
        }
        if self.readings.len() == MANY {
            self.readings.pop_front();
        }
        self.readings.push_back(ms);
    }

    /// Notes how many models a frame fitted.
    pub fn add_models(&mut self, frame: u32, models: u32) {
        if frame >= self.since {
            self.used = Some(models);
        }
    }

    /// How many models `frame`, which is recorded next, may fit.
    pub fn limit(&mut self, target_ms: f32, frame: u32) -> u32 {
        let aim = AIM * target_ms;
        let Some(time) = self.deviation_from(aim) else { return self.limit };
        let used = self.used.unwrap_or(self.limit).min(self.limit);
        let is_needed = used as f32 >= NEEDED * self.limit as f32;
        let wanted = (used as f32 * aim / time.max(1e-6)).round() as u32;
        let wanted = if time > aim { wanted } else { wanted.max(self.limit) };
        let wanted = wanted.clamp(self.least, self.most);
        // What is not needed now is no reason to allow more of it later.
        if wanted != self.limit && (time > aim || is_needed) {
            *self = Self::new([self.least, self.most], wanted, frame);
        }
        self.limit
    }

    /// What frames take, where it is certain to be off the aim.
    fn deviation_from(&self, aim: f32) -> Option<f32> {
        let is_off = |time: &f32, by: f32| (time / aim - 1.0).abs() > by;
        let few = median(self.readings.iter().rev().take(FEW), FEW).filter(|time| is_off(time, LARGE));
        few.or_else(|| median(self.readings.iter(), MANY).filter(|time| is_off(time, SMALL)))
    }
}

/// None where there are fewer than `count`.
fn median<'a>(values: impl Iterator<Item = &'a f32>, count: usize) -> Option<f32> {
    let mut sorted: Vec<f32> = values.copied().collect();
    sorted.sort_by(f32::total_cmp);
    (sorted.len() == count).then(|| sorted[count / 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: [u32; 2] = [100, 4000];

    /// A GPU that takes `fixed_ms` and `model_us` a model, of which the image needs `demand`.
    #[derive(Clone, Copy)]
    struct Gpu {
        fixed_ms: f32,
        model_us: f32,
        demand: u32,
        /// Frames until a time is known.
        latency: u32,
        /// Standard deviation, as a share.
        noise: f32,
    }

    const CALM: Gpu = Gpu { fixed_ms: 2.0, model_us: 1.0, demand: 4000, latency: 3, noise: 0.0 };

    impl Gpu {
        fn ms(&self, limit: u32) -> f32 {
            self.fixed_ms + 1e-3 * self.model_us * limit.min(self.demand) as f32
        }
    }

    /// Sum of twelve uniform numbers: nearly normal, always the same.
    fn normal(frame: u32) -> f32 {
        let mut state = frame.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let mut uniform = || {
            state ^= state << 13;
            state ^= state >> 17;
            state ^= state << 5;
            (state >> 8) as f32 / (1 << 24) as f32
        };
        (0..12).map(|_| uniform()).sum::<f32>() - 6.0
    }

    /// Times and limits of frames. `at` tells the GPU of a frame and what its reading becomes.
    fn run(frames: u32, target_ms: f32, at: impl Fn(u32, f32) -> (Gpu, Option<f32>)) -> (Vec<f32>, Vec<u32>) {
        let mut controller = Controller::new(BOUNDS, 1000, 0);
        let (mut times, mut limits): (Vec<f32>, Vec<u32>) = (vec![], vec![]);
        for frame in 0..frames {
            let latency = at(frame, 0.0).0.latency;
            if let Some(old) = frame.checked_sub(latency) {
                let (gpu, reading) = at(old, times[old as usize]);
                if let Some(ms) = reading {
                    controller.add_time(Reading { frame: old, ms });
                }
                controller.add_models(old, limits[old as usize].min(gpu.demand));
            }
            let limit = controller.limit(target_ms, frame);
            let gpu = at(frame, 0.0).0;
            limits.push(limit);
            times.push(gpu.ms(limit) * (1.0 + gpu.noise * normal(frame)));
        }
        (times, limits)
    }

    fn p95(times: &[f32]) -> f32 {
        let mut sorted = times.to_vec();
        sorted.sort_by(f32::total_cmp);
        sorted[sorted.len() * 95 / 100]
    }

    fn changes(limits: &[u32]) -> usize {
        limits.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    #[test]
    fn frames_of_another_size_get_as_many_models_a_pixel() {
        let mut controller = Controller::new(BOUNDS, 1000, 0);
        controller.rescale(BOUNDS.map(|bound| bound / 4), 7);
        // Times of the old size do not count.
        (0..7).for_each(|frame| controller.add_time(Reading { frame, ms: 50.0 }));
        assert_eq!(controller.limit(1.0, 7), 250);
        // The fewest are those of the new one.
        (7..30).for_each(|frame| controller.add_time(Reading { frame, ms: 50.0 }));
        assert_eq!(controller.limit(1.0, 30), BOUNDS[0] / 4);
    }

    #[test]
    fn it_settles_within_the_target_from_either_side_and_stays() {
        for target_ms in [2.5, 3.0, 4.0, 5.5] {
            let (times, limits) = run(400, target_ms, |_, ms| (CALM, Some(ms)));
            let settled = &times[250..];
            assert!(
                settled.iter().all(|&ms| ms <= target_ms && ms >= 0.89 * target_ms),
                "{target_ms}: {settled:?}"
            );
            assert_eq!(changes(&limits[250..]), 0, "{target_ms}");
            let rises = limits.windows(2).filter(|pair| pair[1] > pair[0]).count();
            assert!(rises == 0 || rises == changes(&limits), "{target_ms}: from one side {limits:?}");
        }
    }

    #[test]
    fn a_step_of_the_cost_is_followed_in_both_directions() {
        let dear = Gpu { fixed_ms: 2.5, model_us: 2.0, ..CALM };
        let (times, _) =
            run(900, 4.0, |frame, ms| (if (300..600).contains(&frame) { dear } else { CALM }, Some(ms)));
        for range in [250..300, 550..600, 850..900] {
            let settled = &times[range.clone()];
            assert!(settled.iter().all(|ms| (3.55..=4.0).contains(ms)), "{range:?}: {settled:?}");
        }
    }

    #[test]
    fn noise_is_not_followed_and_the_slow_frames_keep_the_target() {
        for (noise, tolerance) in [(0.02, 1.05), (0.05, 1.1)] {
            let (times, limits) = run(2000, 4.0, |_, ms| (Gpu { noise, ..CALM }, Some(ms)));
            assert!(p95(&times[300..]) <= tolerance * 4.0, "{noise}: {}", p95(&times[300..]));
            assert!(changes(&limits[300..]) <= 17, "{noise}: {} changes", changes(&limits[300..]));
            let [least, most] =
                [limits[300..].iter().min(), limits[300..].iter().max()].map(|l| *l.unwrap() as f32);
            assert!(most < 1.3 * least, "{noise}: {least} to {most}");
        }
    }

    #[test]
    fn a_stall_changes_nothing() {
        let calm = run(400, 4.0, |_, ms| (CALM, Some(ms))).1;
        for stalled in [20, 21, 300] {
            let limits =
                run(400, 4.0, |frame, ms| (CALM, Some(if frame == stalled { ms + 100.0 } else { ms }))).1;
            assert_eq!(limits[399], calm[399], "at {stalled}");
            assert!(limits.iter().all(|&limit| limit >= *calm.iter().min().unwrap()), "at {stalled}");
        }
        // The same, were it to last.
        let limits = run(400, 4.0, |frame, ms| (CALM, Some(if frame >= 300 { ms + 100.0 } else { ms }))).1;
        assert_eq!(limits[399], BOUNDS[0]);
    }

    #[test]
    fn missing_readings_only_delay() {
        let (times, _) = run(1200, 4.0, |frame, ms| (CALM, (frame % 3 == 0).then_some(ms)));
        assert!(times[900..].iter().all(|ms| (3.55..=4.0).contains(ms)));
        let (_, limits) = run(100, 4.0, |_, _| (CALM, None));
        assert_eq!(changes(&limits), 0, "without any, the limit is held");
    }

    #[test]
    fn latency_does_not_make_it_swing() {
        for (latency, target_ms) in [(1, 2.5), (3, 2.5), (8, 2.5), (8, 5.5)] {
            let (times, limits) = run(600, target_ms, |_, ms| (Gpu { latency, ..CALM }, Some(ms)));
            assert!(
                limits.is_sorted() || limits.iter().rev().is_sorted(),
                "{latency}, {target_ms}: {limits:?}"
            );
            assert!(times[599] <= target_ms && times[599] >= 0.89 * target_ms, "{latency}: {}", times[599]);
        }
    }

    #[test]
    fn a_target_below_the_fixed_cost_ends_at_the_floor() {
        let (_, limits) = run(600, 1.0, |_, ms| (Gpu { noise: 0.05, ..CALM }, Some(ms)));
        assert!(limits[200..].iter().all(|&limit| limit == BOUNDS[0]), "{limits:?}");
    }

    #[test]
    fn what_is_not_needed_is_not_saved_up() {
        let lazy = Gpu { demand: 500, ..CALM };
        let (_, limits) = run(300, 10.0, |_, ms| (lazy, Some(ms)));
        assert!(limits.iter().all(|&limit| limit == 1000), "{limits:?}");
        // When the demand comes, the limit grows from where it was.
        let (times, _) = run(900, 4.0, |frame, ms| (if frame < 300 { lazy } else { CALM }, Some(ms)));
        assert!(times[300..].iter().all(|&ms| ms <= 4.0), "no frame too long");
        assert!(times[600..].iter().all(|&ms| ms >= 3.55));
    }

    #[test]
    fn a_slow_drift_with_spikes_stays_within_the_target() {
        // As a walk through a scene: cost drifts by half over ten seconds, and one frame in fifty takes three times as long.
        let at = |frame: u32, ms: f32| {
            let drift = 1.0 + 0.25 * (frame as f32 / 95.0).sin();
            let gpu = Gpu { model_us: drift, fixed_ms: 2.0 * drift, noise: 0.02, ..CALM };
            (gpu, Some(if frame % 50 == 7 { 3.0 * ms } else { ms }))
        };
        let (times, _) = run(3000, 4.0, at);
        assert!(p95(&times[300..]) <= 1.1 * 4.0, "{}", p95(&times[300..]));
    }

    #[test]
    fn a_new_target_is_followed() {
        let mut controller = Controller::new(BOUNDS, 1000, 0);
        for frame in 0..400 {
            let target_ms = if frame < 200 { 3.15 } else { 6.0 };
            let limit = controller.limit(target_ms, frame);
            controller.add_time(Reading { frame, ms: CALM.ms(limit) });
        }
        assert!(CALM.ms(controller.limit) > 0.89 * 6.0, "{}", controller.limit);
    }
}
