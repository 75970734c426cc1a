//! `report` through the built binary: its numbers against the images it embeds, and its page in a real browser.

mod binary;
mod browser;
mod synthetic;

use binary::{assert_fails, assert_succeeds, demo};
use browser::Page;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

const FRAMES: usize = 6;
const CUT: u64 = 3;

/// A small report, made once: the gallery's four stretches, and a capture with a cut.
struct Report {
    _folder: tempfile::TempDir,
    path: PathBuf,
    page: String,
    json: Value,
    printed: String,
}

fn report() -> &'static Report {
    static REPORT: OnceLock<Report> = OnceLock::new();
    REPORT.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let capture = folder.path().join("cut");
        synthetic::write(&capture, FRAMES);
        synthetic::edit_manifest(&capture, |json| json["frames"][CUT as usize]["restart"] = true.into());
        let out = folder.path().join("out");
        let [capture, out_text] = [&capture, &out].map(|path| path.to_str().unwrap());
        let frames = FRAMES.to_string();
        let printed = assert_succeeds(&demo(&[
            "report",
            "--size",
            "64x36",
            "--frames",
            &frames,
            "--reference",
            "4",
            "--capture",
            capture,
            "--out",
            out_text,
        ]));
        let path = out.join("report.html");
        let page = std::fs::read_to_string(&path).unwrap();
        let json = serde_json::from_str(&std::fs::read_to_string(out.join("report.json")).unwrap()).unwrap();
        Report { _folder: folder, path, page, json, printed }
    })
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap_or_else(|| panic!("{value} is no list"))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

/// An image of a frame as the page holds it.
fn embedded(page: &str, stretch: usize, frame: u64, name: &str) -> image::RgbImage {
    let section = page.split("<section class=\"stretch\"").nth(stretch + 1).unwrap();
    let frame = section.split(&format!("data-frame=\"{frame}\"")).nth(1).unwrap();
    let start = format!(" class=\"image\" data-image=\"{name}\"");
    let image = frame.split("<img").find(|image| image.starts_with(&start)).unwrap();
    let data = image.split("base64,").nth(1).unwrap().split('"').next().unwrap();
    image::load_from_memory(&base64::decode(data).unwrap()).unwrap().to_rgb8()
}

/// Mean squared error of values as shown, 0 to 1.
fn mse(image: &image::RgbImage, reference: &image::RgbImage) -> f64 {
    let squares = image.as_raw().iter().zip(reference.as_raw()).map(|(a, b)| {
        let difference = (f64::from(*a) - f64::from(*b)) / 255.0;
        difference * difference
    });
    squares.sum::<f64>() / image.as_raw().len() as f64
}

fn flip(image: &image::RgbImage, reference: &image::RgbImage) -> f64 {
    let input = |i: &image::RgbImage| nv_flip::FlipImageRgb8::with_data(i.width(), i.height(), i.as_raw());
    let map = nv_flip::flip(input(reference), input(image), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec();
    map.iter().copied().map(f64::from).sum::<f64>() / map.len() as f64
}

#[test]
fn numbers_are_those_of_the_embedded_images() {
    let Report { page, json, .. } = report();
    let mut compared = 0;
    for (i, stretch) in list(&json["stretches"]).iter().enumerate() {
        for shown in list(&stretch["shown"]) {
            let frame = shown["frame"].as_u64().unwrap();
            let reference = embedded(page, i, frame, "reference");
            assert_eq!(Some(u64::from(reference.width())), stretch["width"].as_u64());
            for method in list(&stretch["methods"]) {
                let image = embedded(page, i, frame, method["method"].as_str().unwrap());
                let found = list(&method["frames"]).iter().find(|report| report["frame"] == frame).unwrap();
                let place = format!("{} {frame}: {found}", stretch["name"]);
                let expected = 10f64.powf(-0.1 * number(&found["psnr_db"]));
                // Rounding both images to 8 bits adds 2 / 12 of a squared step.
                assert!(close(mse(&image, &reference), expected, 5e-6 + 0.01 * expected), "{place}");
                // FLIP sees no more than 8 bits.
                assert!(close(flip(&image, &reference), number(&found["flip"]), 1e-6), "{place}");
                compared += 1;
            }
        }
    }
    // One frame of three stretches without an event, three about the lamp's and the capture's, by three methods or more.
    assert!(compared >= 9 * 3, "{compared}");
}

#[test]
fn means_and_margins_follow_from_the_frames() {
    let Report { json, printed, .. } = report();
    let stretches = list(&json["stretches"]);
    let names: Vec<_> = list(&json["summary"]).iter().map(|row| row["method"].as_str().unwrap()).collect();
    assert_eq!(names[0], "quell");
    assert!(names.contains(&"accumulate") && names.contains(&"none"));
    let of = |stretch: &Value, name: &str, key: &str| {
        let methods = list(&stretch["methods"]);
        number(&methods.iter().find(|method| method["method"] == name).unwrap()[key])
    };
    let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
    for (row, name) in list(&json["summary"]).iter().zip(&names) {
        for key in ["psnr_db", "ssim", "flip", "relative_mse", "tpsnr_db"] {
            for stretch in stretches {
                let method =
                    list(&stretch["methods"]).iter().find(|method| method["method"] == *name).unwrap();
                let frames = list(&method["frames"]).iter().filter_map(|frame| frame[key].as_f64());
                assert!(close(mean(frames.collect()), number(&method[key]), 1e-9), "{name} {key}");
            }
            let expected = mean(stretches.iter().map(|stretch| of(stretch, name, key)).collect());
            assert!(close(expected, number(&row[key]), 1e-9), "{name} {key}");
        }
        assert!(printed.contains(&format!("{:.2}", number(&row["psnr_db"]))), "{printed}");
        assert!(number(&row["ms"]) > 0.0);
    }
    let margins = list(&json["margins"]);
    assert_eq!(margins.len(), (names.len() - 2) * (stretches.len() + 1), "a mean and each stretch per rival");
    for margin in margins {
        let rival = margin["rival"].as_str().unwrap();
        let rows = match &margin["stretch"] {
            Value::Null => list(&json["summary"]),
            name => list(&stretches.iter().find(|stretch| stretch["name"] == *name).unwrap()["methods"]),
        };
        let value =
            |name: &str, key: &str| number(&rows.iter().find(|row| row["method"] == name).unwrap()[key]);
        for (key, sign) in
            [("psnr_db", 1.0), ("ssim", 1.0), ("flip", -1.0), ("ms", -1.0), ("memory_mb", -1.0)]
        {
            let gain = sign * (value("quell", key) - value(rival, key));
            assert!(close(gain, number(&margin["gains"][key]), 1e-9), "{margin}");
            let is_lost = list(&margin["lost"]).contains(&key.into());
            assert!(if is_lost { gain < 0.0 } else { gain > -0.051 }, "{key}: {margin}");
        }
    }
}

#[test]
fn events_are_found_and_marked_and_losses_are_visible() {
    let Report { page, json, .. } = report();
    let stretches = list(&json["stretches"]);
    let labels: Vec<Vec<_>> = stretches
        .iter()
        .map(|s| list(&s["events"]).iter().map(|e| e["label"].as_str().unwrap()).collect())
        .collect();
    assert_eq!(labels, [vec![], vec!["lamp off"], vec![], vec![], vec!["cut"]]);
    assert_eq!(stretches[4]["events"][0]["frame"], CUT);
    let shown: Vec<_> =
        list(&stretches[4]["shown"]).iter().map(|shown| shown["frame"].as_u64().unwrap()).collect();
    assert_eq!(shown, [CUT - 1, CUT, FRAMES as u64 - 1]);
    // Two plots each.
    for label in ["lamp off", "cut"] {
        assert_eq!(page.matches(&format!(">{label}</text>")).count(), 2, "{label}");
    }
    // It takes longer than accumulation does, and says so.
    let losses = list(&json["margins"]).iter().filter(|margin| list(&margin["lost"]).contains(&"ms".into()));
    assert!(losses.count() >= 4);
    assert!(page.matches("<td class=\"lost\">").count() >= 4 && page.contains("class=\"tile lost\""));
}

#[test]
fn the_page_needs_no_other_file() {
    let Report { page, .. } = report();
    assert!(!page.contains("{{"), "a placeholder is left");
    let script = page.find("<script>").unwrap();
    for reference in [
        "http:",
        "https:",
        "<link rel=\"stylesheet",
        "url(",
        "@import",
        "fetch(",
        "XMLHttpRequest",
        "<script ",
    ] {
        let found = page.find(reference).filter(|at| !page[*at..].starts_with("http://www.w3.org/2000/svg"));
        assert_eq!(found, None, "{reference}");
    }
    for source in page[..script]
        .split(" src=\"")
        .skip(1)
        .chain(page[..script].split("<link rel=\"icon\" href=\"").skip(1))
    {
        assert!(source.starts_with("data:"), "{}", &source[..source.len().min(60)]);
    }
    assert!(page.len() < 3_000_000, "{} bytes", page.len());
}

/// Where the right image begins, in percent, by what the browser computes.
fn divider(page: &mut Page) -> f64 {
    let clip = page.evaluate("getComputedStyle(document.querySelector('#s1 .stage img.right')).clipPath");
    // A side of 0 is left out at the end.
    let left = clip.as_str().unwrap().trim_end_matches(')').rsplit(' ').next().unwrap().to_owned();
    left.trim_end_matches('%').parse().unwrap_or_else(|_| panic!("{clip}"))
}

fn is_visible(page: &mut Page, side: &str) -> bool {
    let style = format!("getComputedStyle(document.querySelector('#s1 .stage img.{side}')).visibility");
    page.evaluate(&style) == "visible"
}

fn save(screenshot: &[u8], name: &str) {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, screenshot).unwrap();
    let image = image::load_from_memory(screenshot).unwrap().to_rgb8();
    let colours: std::collections::HashSet<_> = image.pixels().collect();
    assert!(colours.len() > 100, "{}: a page with pictures has colours", path.display());
}

#[test]
fn the_page_works_in_a_browser() {
    let mut page = Page::open(&report().path, [1280, 900]);
    page.evaluate(
        "document.querySelector('#s1 .stage').scrollIntoView({ block: 'center', behavior: 'instant' })",
    );
    let loaded =
        "Promise.all([...document.images].filter(i => i.src).map(i => i.decode())).then(all => all.length)";
    assert!(number(&page.evaluate(loaded)) > 30.0);
    let edges = page.evaluate(
        "(() => { const b = document.querySelector('#s1 .stage').getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()",
    );
    let [left, top, width, height] = [0, 1, 2, 3].map(|i| number(&edges[i]));
    let at = |x: f64| [left + x * width, top + 0.5 * height];

    assert!(close(divider(&mut page), 50.0, 0.1));
    page.drag(&[at(0.5), at(0.4), at(0.25)]);
    assert!(close(divider(&mut page), 25.0, 0.5), "dragged to {}", divider(&mut page));
    page.drag(&[at(0.25), at(0.9), [left + width + 300.0, top]]);
    assert!(close(divider(&mut page), 100.0, 0.1), "beyond the edge: {}", divider(&mut page));
    page.swipe(&[at(0.6), at(0.5), at(0.35)]);
    assert!(close(divider(&mut page), 35.0, 1.0), "by touch to {}", divider(&mut page));

    page.evaluate("document.querySelector('#s1 .stage').focus()");
    page.press("ArrowRight");
    assert!(close(divider(&mut page), 37.0, 1.0));
    page.press("ArrowLeft");
    page.press("ArrowLeft");
    assert!(close(divider(&mut page), 33.0, 1.0));
    page.press("Home");
    assert!(close(divider(&mut page), 0.0, 0.1));
    let announced = "document.querySelector('#s1 .stage').getAttribute('aria-valuenow')";
    assert_eq!(page.evaluate(announced), "0");

    // In turns, by key and by pointer; the slider comes back.
    page.press("f");
    let sides = |page: &mut Page| [is_visible(page, "left"), is_visible(page, "right")];
    assert_eq!(sides(&mut page), [false, true]);
    page.press("f");
    assert_eq!(sides(&mut page), [true, false]);
    page.drag(&[at(0.5)]);
    assert_eq!(sides(&mut page), [false, true]);
    page.press("s");
    assert_eq!(sides(&mut page), [true, true]);

    // Other images and another frame, without a jump of the layout.
    let place = "document.querySelector('#s1 .moment:not([hidden]) h3').getBoundingClientRect().top";
    let before = page.evaluate(place);
    let shown = "document.querySelector('#s1 .stage img.right').src";
    let quell = page.evaluate(shown);
    page.evaluate("document.querySelector('input[name=\"s1-right\"][value=reference]').click()");
    let reference = page.evaluate(shown);
    assert_ne!(reference, quell);
    assert_eq!(page.evaluate("document.querySelector('#s1 .tag.right').textContent"), "reference");
    page.evaluate("document.querySelector('input[name=\"s1-frame\"]').click()");
    assert_ne!(page.evaluate(shown), reference);
    assert_eq!(page.evaluate("document.querySelectorAll('#s1 .moment:not([hidden])').length"), 1);
    assert_eq!(page.evaluate(place), before);

    // A crop holds the image's pixels.
    let pixels = page.evaluate(
        "(async () => {
            await new Promise(done => setTimeout(done, 300));
            const crop = document.querySelector('#s1 .moment:not([hidden]) canvas');
            const image = crop.closest('.moment').querySelector(`img[data-image=\"${crop.dataset.image}\"]`);
            const whole = document.createElement('canvas');
            [whole.width, whole.height] = [image.naturalWidth, image.naturalHeight];
            const context = whole.getContext('2d');
            context.drawImage(image, 0, 0);
            const expected = context.getImageData(+crop.dataset.x, +crop.dataset.y, crop.width, crop.height).data;
            const found = crop.getContext('2d').getImageData(0, 0, crop.width, crop.height).data;
            return [found.length, found.every((value, i) => value === expected[i]), new Set(found).size];
        })()",
    );
    assert!(number(&pixels[0]) > 0.0 && pixels[1] == true && number(&pixels[2]) > 8.0, "{pixels}");

    save(&page.screenshot(true), "report_1280.png");
    for width in [1280, 390] {
        page.resize([width, 844]);
        let overflow =
            page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth");
        assert_eq!(overflow, 0, "wider than a window of {width} pixels");
    }
    save(&page.screenshot(true), "report_390.png");
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
    let foreign: Vec<_> = page.requested.iter().filter(|url| !url.starts_with("data:")).collect();
    assert!(foreign.len() == 1 && foreign[0].ends_with("/report.html"), "{foreign:?}");
}

#[test]
fn a_broken_script_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.html");
    std::fs::write(&path, "<script>undefined_function()</script><script>console.error('x')</script>")
        .unwrap();
    let mut page = Page::open(&path, [640, 480]);
    page.evaluate("0");
    assert_eq!(page.complaints.len(), 2, "{:?}", page.complaints);
}

#[test]
fn wrong_arguments_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let report = |more: &[&str]| demo(&[&["report", "--out", out.to_str().unwrap()], more].concat());
    assert_fails(&report(&["--no-gallery"]), 1, &["nothing to report on", "--scene", "--capture"]);
    assert_fails(&report(&["--capture", "no such capture"]), 1, &["no such capture", "capture.json"]);
    assert_fails(
        &report(&["--frames", "8", "--reference-frames", "8"]),
        1,
        &["reference frame 8", "8 frames"],
    );
    assert!(!out.exists(), "nothing is left behind");
    assert_fails(&report(&["--reference", "0"]), 2, &["--reference", "0"]);
    assert_fails(&report(&["--method", "magic"]), 2, &["magic", "quell"]);
    let capture = folder.path().join("capture");
    synthetic::write(&capture, 1);
    synthetic::edit_channels(&capture.join("frame_0000.exr"), |channels| {
        channels.retain(|(name, _)| !name.starts_with("reference"));
    });
    let output = report(&["--no-gallery", "--capture", capture.to_str().unwrap()]);
    assert_fails(&output, 1, &["capture: no frame has a reference", "reference.R"]);
}
