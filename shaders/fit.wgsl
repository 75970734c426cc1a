// fit: one linear model per listed centre, with the window that its own error chooses.
//
// Windows are nested: a cross of five tiles, 3x3, 5x5. By the ring error, what each adds, a ring, first tests the model of the window
// inside it, then joins. By Mallows' Cp only the least and the widest are fitted.
//
// Reads   moments, centre_list, levels; kept: the windows of the frame before.
// Writes  models, windows, coverage (layout: include/models)
// Source  Moon et al. 2015, section 4, with the recursion over pixels replaced by the equal sum of tile moments; Mallows,
//         "Some Comments on Cp", Technometrics 1973

//!include frame numbers surface features linear_model windows models window ridge cover

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> level: vec4<u32>; // its number in x
@group(0) @binding(2) var<storage, read> moments: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> centre_list: array<u32>;
@group(0) @binding(4) var<storage, read> levels: array<u32>;
@group(0) @binding(5) var<storage, read_write> models: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> windows: array<u32>;
@group(0) @binding(7) var<storage, read_write> coverage: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read> kept: array<u32>;

const OWN_FEATURES = MODEL_OWN_FEATURES;
const LANES = 32u; // half a wave or all of one: most of what is done is narrow, and waits
const RIDGE = 1e-3; // of the total weight

// Of the window so far: weight, noises and columns about the origin. Squares about the origin are kept by the lanes, four by each.
var<workgroup> sums: array<f32, TILE_SQUARES>;
// The model's error in luminance, as a linear form of the columns about the window's mean.
var<workgroup> form: array<f32, COLUMNS>;
var<workgroup> partial: array<vec2<f32>, LANES>;

// Variance of one sample over its squared mean that is believed; more comes of windows that are all but black.
const MOST_NOISE = 1e3;

@compute @workgroup_size(LANES)
fn fit(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let listed = group.y * LEVEL_COLUMNS + group.x;
    if listed >= levels[level.x * LEVEL_WORDS + LEVEL_COUNT] {
        return;
    }
    let centre = centre_list[listed];
    let place = vec2(centre % frame.tiles.x, centre / frame.tiles.x);
    // Under a budget the coarsest models are what remains where there are no others, so each has the widest window.
    let is_base = has(frame, FLAG_LIMITED) && level.x == 0u;
    let by_ring = has(frame, FLAG_RING_ERROR);
    var first = select(frame.least_window, 1u, by_ring);
    var widest = select(frame.widest_window, WIDEST_WINDOW, is_base);
    // What a tile chose lately it would choose again.
    let known = stored_window(kept[centre]);
    if !is_base && !by_ring && is_settled(known, place, centre) {
        first = known;
        widest = known;
    }
    load_window(place, WINDOW_TILES[widest], lane);

    let places = square_quad(lane);
    var squares = vec4(0.0);
    var error = 0.0;  // for the ring error: of the innermost model, then of each model on the ring about its window
    var tested = 0.0; // weight of what they were tested on
    var least = 1e38;
    var chosen = widest;
    var inside = 0u; // the window that the next one is about
    var size = first;
    loop {
        let ring = vec2(WINDOW_TILES[inside], WINDOW_TILES[size]); // the first of its tiles, and that after the last
        if by_ring && inside > 0u {
            error += ring_error(ring, places, lane);
            tested += window_weight(ring.x, ring.y);
        }
        if lane < SQUARE_QUADS {
            squares += window_squares(lane, places, ring.x, ring.y);
        }
        if lane < TILE_SQUARES {
            var moment = window_moment(lane, ring.x, ring.y);
            if inside > 0u {
                moment += sums[lane];
            }
            sums[lane] = moment;
        }
        workgroupBarrier();
        let residual = solve(size, squares, places, lane);
        var risk = mallows_cp(residual, size);
        if by_ring {
            if inside == 0u {
                // No model is inside the first window to be tested by it, so it is judged by Cp.
                tested = sums[TILE_WEIGHT];
                error = risk * tested;
            }
            risk = error / max(tested, 1e-30);
        }
        // A window without samples has shown nothing. The widest has some: `centres` lists no others.
        let is_better = sums[TILE_WEIGHT] > 0.0 && size >= frame.least_window && risk < least;
        if is_better {
            least = risk;
            chosen = size;
        }
        if select(is_better, size == widest, is_base) {
            write_model(centre * MODEL_STRIDE, residual, risk, lane);
        }
        workgroupBarrier();
        if size == widest {
            break;
        }
        inside = size;
        // Cp has two windows to choose from: with those between, a frame takes longer and is no better.
        size = select(widest, size + 1u, by_ring);
    }
    if lane == 0u {
        windows[centre] = select(chosen, widest, is_base);
    }
    // Where a narrower window would be better, finer levels may add models; the wide one then counts for little by its trust.
    if lane < MOST_TILES && (!is_base || (chosen == widest && widest == frame.widest_window)) {
        cover(place, chosen, lane);
    }
}

// Whether a tile need not choose its window: it does in one of so many frames, in turns. A function, so that tests/cost can leave it out
// of frames in which all choose.
fn is_settled(known: u32, place: vec2<u32>, centre: u32) -> bool {
    let may_be_chosen = known == frame.least_window || known == frame.widest_window;
    let has_samples = moments[centre * TILE_STRIDE][TILE_WEIGHT] > 0.0; // so any window has
    return may_be_chosen && has_samples && (place.x + 2u * place.y + frame.index) % CHOICE_FRAMES != 0u;
}

const CHOICE_FRAMES = 4u;

// Squared error, summed over the ring about a window, of the model that knows the window inside it only: exactly what predicting
// pixel by pixel would find. The error is a linear form of the columns, so its square needs first and second moments only.
fn ring_error(tiles: vec2<u32>, places: SquareQuad, lane: u32) -> f32 {
    var sum = vec2(0.0); // squares, the form of the sums
    if lane < SQUARE_QUADS {
        sum.x = form_square(window_squares(lane, places, tiles.x, tiles.y), places, lane);
    }
    if lane < COLUMNS {
        sum.y = form[lane] * window_moment(TILE_MEAN + lane, tiles.x, tiles.y);
    }
    let ring = workgroup_sum(sum, lane);
    var mean = 0.0;
    for (var i = 0u; i < COLUMNS; i++) {
        mean += form[i] * sums[TILE_MEAN + i];
    }
    mean /= max(sums[TILE_WEIGHT], 1e-30);
    let error = max(ring.x + mean * (window_weight(tiles.x, tiles.y) * mean - 2.0 * ring.y), 0.0);
    workgroupBarrier(); // all have read the sums, which the ring now joins
    return error;
}

// Fits the window so far, and tells the squared error of luminance on it.
fn solve(size: u32, squares: vec4<f32>, places: SquareQuad, lane: u32) -> f32 {
    // An empty window solves a harmless system instead of leaving uniform control flow.
    let weight = select(1.0, sums[TILE_WEIGHT], sums[TILE_WEIGHT] > 0.0);
    if lane < SQUARE_QUADS {
        var of_means: vec4<f32>;
        for (var i = 0u; i < 4u; i++) {
            of_means[i] = sums[TILE_MEAN + places.rows[i]] * sums[TILE_MEAN + places.columns[i]];
        }
        ridge_squares[lane] = squares - of_means / weight;
    }
    if lane < FEATURES {
        let depth = length(vec3(column_mean(3u), column_mean(4u), column_mean(5u)));
        let own = lane >= SURFACE_FEATURES;
        ridge_floors[lane] = select(feature_floor(lane, depth), 0.5, own);
        // Noise of one sample over the prior's variance, that of a slope of the mean colour per unit.
        let unit = select(feature_unit(lane, depth), WINDOW_REACHES[size], own);
        ridge_priors[lane] = relative_noise() * unit * unit;
    }
    workgroupBarrier();
    ridge_solve(weight, lane);
    if lane < FEATURES {
        form[lane] = -luminance_slope(lane);
    } else if lane < COLUMNS {
        form[lane] = LUMINANCE[lane - FEATURES];
    }
    workgroupBarrier();
    let own = form_square(ridge_squares[min(lane, SQUARE_QUADS - 1u)], places, lane);
    return max(workgroup_sum(vec2(own, 0.0), lane).x, 0.0);
}

// What a lane's squares add to the square of the form: twice off the diagonal.
fn form_square(values: vec4<f32>, places: SquareQuad, lane: u32) -> f32 {
    var sum = 0.0;
    for (var i = 0u; i < 4u; i++) {
        let at = vec2(places.rows[i], places.columns[i]);
        let times = select(select(2.0, 1.0, at.x == at.y), 0.0, 4u * lane + i >= SQUARES);
        sum += times * form[at.x] * form[at.y] * values[i];
    }
    return sum;
}

fn column_mean(column: u32) -> f32 {
    return origin_of(column) + sums[TILE_MEAN + column] / max(sums[TILE_WEIGHT], 1e-30);
}

fn noise_mean(entry: u32) -> f32 {
    return sums[entry] / max(sums[TILE_WEIGHT], 1e-30);
}

fn workgroup_sum(value: vec2<f32>, lane: u32) -> vec2<f32> {
    partial[lane] = value;
    workgroupBarrier();
    var total = vec2(0.0);
    for (var i = 0u; i < LANES; i++) {
        total += partial[i];
    }
    return total;
}

// Mean squared error on the window, with what fitting has made it too small by.
fn mallows_cp(residual: f32, size: u32) -> f32 {
    let pixels = f32(TILE * TILE * sampled_tiles(size));
    let parameters = f32(FEATURES + 1u);
    return residual / max(sums[TILE_WEIGHT], 1e-30)
        + 2.0 * parameters * noise_mean(TILE_FOUND) / max(pixels, 1.0);
}

fn sampled_tiles(size: u32) -> u32 {
    var count = 0u;
    for (var t = 0u; t < WINDOW_TILES[size]; t++) {
        count += select(0u, 1u, window_factors[t] > 0.0);
    }
    return count;
}

// Variance of one sample over its squared mean.
fn relative_noise() -> f32 {
    let colour = luminance(vec3(column_mean(FEATURES), column_mean(FEATURES + 1u), column_mean(FEATURES + 2u)));
    return min(noise_mean(TILE_VARIANCE) / max(colour * colour, 1e-12), MOST_NOISE);
}

// How much less the temporal means vary than as many independent samples would: resampling averages over neighbours, and
// an exponential mean of length n over more than n samples.
fn noise_gain() -> f32 {
    let expected = noise_mean(TILE_EXPECTED);
    return select(1.0, clamp(noise_mean(TILE_FOUND) / expected, 0.0, 1.0), expected > 0.0);
}

const LEAST_TRUST = 1e-4; // where all models are bad, they still are compared

// Squared ratio of the temporal means' noise and the model's residual: 1 where it explains all but noise, less where an edge
// that no feature knows runs through the window. So pixels beside the edge are predicted by the models on their side.
fn trust(residual: f32) -> f32 {
    let noise = sums[TILE_FOUND];
    let fit = clamp(noise / max(residual, 1e-20), LEAST_TRUST, 1.0);
    return fit * fit;
}

fn write_model(start: u32, residual: f32, risk: f32, lane: u32) {
    if lane == 0u {
        let error = max(risk - noise_mean(TILE_FOUND), 0.0);
        models[start] = vec4(trust(residual), noise_gain(), relative_noise(), error);
    }
    if lane < CHANNELS * MODEL_ROW {
        models[start + 1u + lane] = model_part(lane / MODEL_ROW, lane % MODEL_ROW);
    }
}
