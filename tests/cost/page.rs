//! The whole table, from all that can be found out on this machine.

use crate::compare;
use crate::driver::{self, Compiled, FAMILIES};
use crate::resources::{self, Held, SIZES};
use crate::roofline::{self, GPUS, Need};
use crate::shader::{SPECULAR_PREFIX, Shader};
use crate::table::{Section, made_by, render};
use crate::traffic::{self, Bytes};
use crate::work::{self, LEFT_OUT};

const HEAD: &str = "\
# Cost without a GPU

What can be known of a frame's cost without running it on a GPU. Written by `tests/cost.sh`; `cargo test --test cost` \
compares: a figure that grew by more than 10 %, a spilled register or a kernel that is not in the table fails. Rows are \
kernels in the order they run, then those that are compiled anew for the specular signal, and for hit distances without it; `centres` and `fit` make the pass `fit`, under a budget with `gains` and `choose`. MB are 10^6 bytes.";

const MEMORY: &str = "All that `Denoiser::memory` lists; the caller's images are not in it. The `specular_` resources and `rest` exist once a frame's \
specular radiance came apart; `all` is without them.";

const WORKGROUPS: &str = "Bytes are the shader's workgroup variables; WebGPU's default limit is 16384.";

pub fn page(shaders: &[Shader]) -> String {
    let held = resources::held();
    let traffic = traffic::all(shaders, &resources::per_pixel(&held[0].all, SIZES[0]));
    let mut sections =
        vec![memory(&held), traffic_section(&traffic), work_section(shaders), workgroups(shaders)];
    if driver::expected() {
        let compiled = driver::compile();
        sections.extend(FAMILIES.iter().zip(&compiled).map(|(&of, made)| driver_section(of, made, shaders)));
        let needs = needs(shaders, &traffic, &compiled[0]);
        sections.extend(GPUS.iter().map(|gpu| estimate(gpu, &needs)));
        say_once(&mut sections);
    }
    render(HEAD, &sections)
}

/// Rules that the section before has stated already.
fn say_once(sections: &mut [Section]) {
    for i in (1..sections.len()).rev() {
        for rules in [driver::RULES, roofline::RULES] {
            if sections[i - 1].prose.contains(rules) {
                sections[i].prose = sections[i].prose.replace(rules, "As above.");
            }
        }
    }
}

fn memory(held: &[Held; 2]) -> Section {
    let pixels = SIZES.map(|[width, height]| f64::from(width) * f64::from(height));
    let cells = |bytes: [u64; 2]| {
        let [full_hd, quad_hd] = bytes.map(|bytes| format!("{:.2}", bytes as f64 / 1e6));
        vec![format!("{:.2}", bytes[0] as f64 / pixels[0]), full_hd, quad_hd]
    };
    let mut rows: Vec<_> = (held[0].all.iter())
        .zip(&held[1].all)
        .map(|(full_hd, quad_hd)| (full_hd.0.to_owned(), cells([full_hd.1, quad_hd.1])))
        .collect();
    let sums = |held: &Held| [held.without_split(), held.all.iter().map(|(_, bytes)| bytes).sum()];
    let [full_hd, quad_hd] = held.each_ref().map(sums);
    for (i, name) in ["all", "all of a split"].into_iter().enumerate() {
        rows.push((name.to_owned(), cells([full_hd[i], quad_hd[i]])));
    }
    let columns = vec!["bytes a pixel", "MB at 1920x1080", "MB at 2560x1440"];
    Section { title: "Memory".into(), prose: MEMORY.into(), columns, rows }
}

fn traffic_section(traffic: &[(String, Bytes)]) -> Section {
    let cells = |bytes: &Bytes| {
        (0..2)
            .flat_map(|formats| [bytes.read[formats], bytes.written[formats], bytes.total(formats)])
            .map(|bytes| format!("{bytes:.2}"))
            .collect()
    };
    Section {
        title: "Traffic".into(),
        prose: traffic::RULES.into(),
        columns: vec!["read", "written", "total", "most read", "most written", "most total"],
        rows: traffic.iter().map(|(name, bytes)| (name.clone(), cells(bytes))).collect(),
    }
}

fn work_section(shaders: &[Shader]) -> Section {
    let row = |shader: &Shader| {
        let [still, moving, worst] = LEFT_OUT.map(|left_out| work::of(shader, left_out));
        let cells = [
            moving.operations,
            moving.shared,
            moving.buffers,
            moving.barriers,
            still.texels,
            moving.texels,
            worst.texels,
        ];
        (shader.name().to_owned(), cells.map(|n| n.to_string()).to_vec())
    };
    Section {
        title: "Work".into(),
        prose: work::RULES.into(),
        columns: vec![
            "operations",
            "shared",
            "buffers",
            "barriers",
            "texels still",
            "texels moving",
            "texels worst",
        ],
        rows: shaders.iter().map(row).collect(),
    }
}

fn workgroups(shaders: &[Shader]) -> Section {
    let row = |shader: &Shader| {
        let cells = [shader.invocations(), shader.workgroup_bytes()];
        (shader.name().to_owned(), cells.map(|n| n.to_string()).to_vec())
    };
    Section {
        title: "Workgroups".into(),
        prose: WORKGROUPS.into(),
        columns: vec!["invocations", "bytes"],
        rows: shaders.iter().map(row).collect(),
    }
}

fn driver_section((family, of): (&str, &str), made: &Compiled, shaders: &[Shader]) -> Section {
    let cell = |kernel: &str, statistic: &str| {
        let value = made.statistics.get(&(kernel.to_owned(), statistic.to_owned()));
        // A driver that says nothing of spills would pass unseen.
        assert!(value.is_some() || !statistic.starts_with("Spilled"), "{kernel}: no `{statistic}` from RADV");
        value.map_or("?".to_owned(), u64::to_string)
    };
    let row = |shader: &Shader| {
        let cells = driver::COLUMNS.iter().map(|(_, statistic)| cell(shader.name(), statistic)).collect();
        (shader.name().to_owned(), cells)
    };
    Section {
        title: format!("{}: {family} ({of})", compare::DRIVER_SECTION),
        prose: made_by(&made.driver, driver::RULES),
        columns: driver::COLUMNS.iter().map(|&(column, _)| column).collect(),
        rows: shaders.iter().map(row).collect(),
    }
}

/// What each kernel of a frame needs in a moving view.
fn needs(shaders: &[Shader], traffic: &[(String, Bytes)], compiled: &Compiled) -> Vec<(String, Need)> {
    let is_needed = |name: &str| traffic::is_in_frame(name) || name.starts_with(SPECULAR_PREFIX);
    let rows = traffic.iter().filter(|(name, _)| !name.ends_with("frame") && is_needed(name));
    let need = |(name, bytes): &(String, Bytes)| {
        let mut need = Need { bytes: *bytes, ..Need::default() };
        if let Some(shader) = shaders.iter().find(|shader| shader.name() == name) {
            let cycles = compiled.statistics.get(&(name.clone(), driver::CYCLES.to_owned()));
            need.cycles = cycles.map_or(0.0, |&cycles| cycles as f64);
            need.work = work::of(shader, LEFT_OUT[1]);
            need.invocations = shader.invocations();
            need.tiles = traffic::tiles_of(shader);
        }
        (name.clone(), need)
    };
    rows.map(need).collect()
}

fn estimate(gpu: &roofline::Gpu, needs: &[(String, Need)]) -> Section {
    let (mut frame, mut split) = ([0.0; 4], [0.0; 4]);
    let mut rows: Vec<_> = needs
        .iter()
        .map(|(name, need)| {
            let times = SIZES.map(|size| roofline::times(gpu, name, need, size));
            let totals = times.map(|times| [times.least(), times.most()]);
            let is_specular = name.starts_with(SPECULAR_PREFIX);
            let rounds = if traffic::SHARED.contains(&name.as_str()) { 2.0 } else { 1.0 };
            for (i, total) in totals.as_flattened().iter().enumerate() {
                frame[i] += if is_specular { 0.0 } else { *total };
                split[i] += rounds * total;
            }
            let parts = [times[0].memory, times[0].by_driver, times[0].by_work, times[0].dispatches];
            let cells = parts.iter().chain(totals.as_flattened());
            let cells = cells.map(|ms| format!("{ms:.3}")).chain([times[0].bound().to_owned()]);
            (name.clone(), cells.collect())
        })
        .collect();
    for (name, sums) in [("frame", frame), ("split frame", split)] {
        let blank = std::iter::repeat_n(String::new(), 4);
        let sums = sums.map(|ms| format!("{ms:.2}"));
        rows.push((name.into(), blank.chain(sums).chain([String::new()]).collect()));
    }
    Section {
        title: format!("{}: {}", compare::ESTIMATE_SECTION, gpu.name),
        prose: format!(
            "{}\n\n{} GB/s and {} TFLOP/s FP32 ({}).",
            roofline::RULES,
            gpu.gigabytes_a_second,
            gpu.teraflops,
            gpu.source
        ),
        columns: vec![
            "memory",
            "by driver",
            "by work",
            "dispatches",
            "least 1080p",
            "most 1080p",
            "least 1440p",
            "most 1440p",
            "bound by",
        ],
        rows,
    }
}
