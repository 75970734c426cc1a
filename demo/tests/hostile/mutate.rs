//! Changes to files: to JSON with its structure in mind, and to bytes.

use rand::Rng;
use rand::rngs::SmallRng;
use serde_json::{Map, Value, json};

/// Numbers at the edges of types, and just beside what files hold.
const NUMBERS: [f64; 22] = [
    0.0,
    1.0,
    2.0,
    3.0,
    4.0,
    255.0,
    -1.0,
    0.5,
    1e-40,
    65_535.0,
    65_536.0,
    16_777_217.0,
    2_147_483_647.0,
    2_147_483_648.0,
    4_294_967_295.0,
    4_294_967_296.0,
    9_007_199_254_740_992.0,
    1.8e19,
    1e30,
    -1e30,
    3.4e38,
    1e308,
];

/// Words that mean something to the readers.
const WORDS: [&str; 16] = [
    "",
    "SCALAR",
    "VEC2",
    "VEC3",
    "MAT4",
    "CUBICSPLINE",
    "STEP",
    "orthographic",
    "perspective",
    "spot",
    "directional",
    "weights",
    "rotation",
    "BLEND",
    "image/jpeg",
    "\u{0}\u{1b}[31m",
];

pub fn pick<'a, T>(random: &mut SmallRng, list: &'a [T]) -> &'a T {
    &list[random.random_range(0..list.len())]
}

/// One change to `json`, in words. `paths` are hostile strings for places where files are named.
pub fn mutate_json(random: &mut SmallRng, json: &mut Value, paths: &[String]) -> String {
    let mut pointers = Vec::new();
    collect(json, String::new(), &mut pointers);
    let pointer = pick(random, &pointers).clone();
    let other = json.pointer(pick(random, &pointers).as_str()).cloned().unwrap_or_default();
    // A file's name is one string among hundreds of values.
    let names: Vec<&String> =
        pointers.iter().filter(|p| p.ends_with("/uri") || p.ends_with("/file")).collect();
    if !names.is_empty() && random.random_ratio(1, 6) {
        let (pointer, path) = (pick(random, &names).as_str(), pick(random, paths));
        *json.pointer_mut(pointer).unwrap() = json!(path);
        return format!("{pointer} = {path:?}");
    }
    let choice = random.random_range(0..10);
    if choice < 2
        && let Some((parent, key)) = pointer.rsplit_once('/')
        && let Some(parent) = json.pointer_mut(parent)
    {
        match parent {
            Value::Object(map) => drop(map.remove(key)),
            Value::Array(list) => drop(list.remove(key.parse().unwrap())),
            _ => {}
        }
        return format!("{pointer} removed");
    }
    let value = json.pointer_mut(&pointer).unwrap();
    let new = match (choice, &mut *value) {
        (2, Value::Array(list)) if !list.is_empty() => {
            // Many of the same.
            let times = *pick(random, &[1, 2, 100]);
            let item = pick(random, list).clone();
            list.extend(std::iter::repeat_n(item, times));
            return format!("{pointer} has one item {times} times more");
        }
        (2, Value::Object(map)) => {
            let (key, value) = (pick(random, &WORDS).to_string(), other);
            map.insert(key.clone(), value);
            return format!("{pointer} has a new {key:?}");
        }
        (3, _) => other,
        (4, _) if random.random_bool(0.5) => match random.random_range(0..6) {
            0 => Value::Null,
            1 => json!([]),
            2 => json!({}),
            3 => json!(true),
            4 => json!("x".repeat(100_000)),
            _ => nested(random.random_range(1..300)),
        },
        (_, Value::Number(old)) => number(random, old.as_f64().unwrap_or(0.0)),
        (_, Value::String(_)) => json!(pick(random, &WORDS)),
        _ => json!(pick(random, &NUMBERS)),
    };
    let shown: String = new.to_string().chars().take(80).collect();
    *value = new;
    format!("{pointer} = {shown}")
}

fn number(random: &mut SmallRng, old: f64) -> Value {
    let new = match random.random_range(0..3) {
        0 => old + 1.0,
        1 => -old,
        _ => *pick(random, &NUMBERS),
    };
    // Whole numbers must look like some to be taken for an index.
    if new.fract() == 0.0 && (0.0..1.8e19).contains(&new) { json!(new as u64) } else { json!(new) }
}

fn nested(depth: usize) -> Value {
    (0..depth).fold(json!(1), |inner, i| if i % 2 == 0 { json!([inner]) } else { json!({"a": inner}) })
}

fn collect(value: &Value, at: String, out: &mut Vec<String>) {
    let children: Vec<(String, &Value)> = match value {
        Value::Array(list) => list.iter().enumerate().map(|(i, v)| (i.to_string(), v)).collect(),
        Value::Object(map) => {
            let map: &Map<String, Value> = map;
            map.iter().map(|(k, v)| (k.replace('~', "~0").replace('/', "~1"), v)).collect()
        }
        _ => Vec::new(),
    };
    out.push(at.clone());
    for (key, child) in children {
        collect(child, format!("{at}/{key}"), out);
    }
}

/// Some changes to `bytes`, in words. Half of them within the first `head` bytes, where files have their structure.
pub fn mutate_bytes(random: &mut SmallRng, bytes: &mut Vec<u8>, head: usize) -> String {
    let mut words = Vec::new();
    for _ in 0..*pick(random, &[1, 1, 1, 2, 8]) {
        if bytes.is_empty() {
            break;
        }
        let end = if random.random_bool(0.5) { head.clamp(1, bytes.len()) } else { bytes.len() };
        let at = random.random_range(0..end);
        words.push(match random.random_range(0..7) {
            0 => {
                bytes.truncate(at);
                format!("cut at {at}")
            }
            1 | 2 => {
                let bit = random.random_range(0..8);
                bytes[at] ^= 1 << bit;
                format!("bit {bit} of {at}")
            }
            3 => {
                bytes[at] = *pick(random, &[0, 1, 0x7f, 0x80, 0xff]);
                format!("{at} = {}", bytes[at])
            }
            4 => {
                let value =
                    *pick(random, &[0, 1, 0x7fff_ffff, 0x8000_0000, 0xffff_ffff, 1_u32 << 24, 60_000]);
                let field = &mut bytes[at..(at + 4).min(end)];
                let length = field.len();
                // Both orders are in use.
                let order = if random.random_bool(0.5) { value.to_le_bytes() } else { value.to_be_bytes() };
                field.copy_from_slice(&order[..length]);
                format!("{at}.. = {order:?}")
            }
            5 => {
                let count = random.random_range(1..=16.min(bytes.len() - at));
                bytes.drain(at..at + count);
                format!("{count} gone at {at}")
            }
            _ => {
                let count = random.random_range(1..=16.min(bytes.len() - at));
                let copy = bytes[at..at + count].to_vec();
                bytes.splice(at..at, copy);
                format!("{count} doubled at {at}")
            }
        });
    }
    words.join(", ")
}
