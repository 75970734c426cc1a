//! `study` through the built binary: the page, its numbers, and what it says when something is wrong.

mod binary;

use binary::{assert_fails, assert_succeeds, demo};
use serde_json::Value;
use std::path::Path;

const SIZE: &str = "64x36";

fn study(out: &Path, more: &[&str]) -> std::process::Output {
    let tiny =
        ["study", "--size", SIZE, "--spp", "2", "--reference", "64", "--runs", "2", "--frames", "6", "--out"];
    demo(&[&tiny[..], &[out.to_str().unwrap()], more].concat())
}

#[test]
fn a_study_is_a_page_with_the_numbers_of_its_json() {
    let folder = tempfile::tempdir().unwrap();
    let more = ["--seed", "5", "--zoom", "8,4,20,10", "--pixels", "30,30", "12,20"];
    let summary = assert_succeeds(&study(folder.path(), &more));
    let page = std::fs::read_to_string(folder.path().join("study.html")).unwrap();
    let json = std::fs::read_to_string(folder.path().join("study.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();

    for id in ["centres", "zoom", "numbers", "tracking", "curves", "convergence"] {
        assert!(page.contains(&format!("id=\"{id}\"")), "no section {id}");
    }
    assert!(!page.contains("{{"), "a placeholder is left");
    let references = ["http:", "https:", "src=\"/", "src=\"study", "<link", "url("];
    for reference in references {
        assert!(!page.contains(reference), "{reference}: the page must need nothing else");
    }
    // Three images, their centres, five enlarged parts, noisy and reference.
    assert_eq!(page.matches("src=\"data:image/png;base64,iVBORw0KGgo").count(), 13);
    // A histogram per window size, curves per pixel, convergence.
    assert_eq!(page.matches("class=\"plot\"").count(), 3 + 2 + 1);

    assert_eq!((&json["spp"], &json["reference_spp"], &json["seed"]), (&2.into(), &64.into(), &5.into()));
    assert_eq!(json["zoom"], serde_json::json!({ "x": 8, "y": 4, "width": 20, "height": 10 }));
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    let variants = json["variants"].as_array().unwrap();
    assert_eq!(variants.len(), 7);
    for variant in variants {
        let models = number(&variant["models"]);
        assert!(models >= 1.0 && number(&variant["wall_ms"]) > 0.0);
        assert!((number(&variant["pixels_per_model"]) - 64.0 * 36.0 / models).abs() < 1e-9);
        let cells = |metrics: &Value| format!("<td>{:.2}</td>", number(&metrics["psnr_db"]));
        let row =
            format!("<td class=\"text\">{}</td><td>{models}</td>", variant["windows"].as_str().unwrap());
        assert!(page.contains(&row), "{row}");
        assert!(page.contains(&cells(&variant["output"])) && page.contains(&cells(&variant["models_alone"])));
        assert!(summary.contains(&format!("{:.2} dB", number(&variant["output"]["psnr_db"]))), "{summary}");
        assert!(number(&variant["output"]["psnr_db"]) > number(&json["noisy"]["psnr_db"]));
    }
    let models =
        |name: &str| number(&variants.iter().find(|variant| variant["name"] == name).unwrap()["models"]);
    assert_eq!(models("dense"), 8.0 * 5.0, "one per tile");
    // So small an image is half border, where windows reach no neighbour.
    assert!(models("adaptive") < 0.8 * models("dense"), "{}", models("adaptive"));

    for window in json["windows"].as_array().unwrap() {
        for kind in ["expected", "own"] {
            for correlation in ["pearson_log", "spearman"] {
                let value = number(&window[kind][correlation]);
                assert!(page.contains(&format!("<td>{value:.3}</td>")), "{kind} {correlation} {value}");
            }
        }
    }
    let pixels = json["pixels"].as_array().unwrap();
    let places: Vec<_> = pixels.iter().map(|pixel| (&pixel["x"], &pixel["y"])).collect();
    assert_eq!(places, [(&30.into(), &30.into()), (&12.into(), &20.into())]);
    for pixel in pixels {
        assert!(page.contains(&format!("pixel {}, {}", pixel["x"], pixel["y"])));
        assert_eq!(pixel["true_error"].as_array().unwrap().len(), 3);
        assert_eq!(pixel["estimated_error"].as_array().unwrap().len(), 2, "one of each run");
    }
    check_convergence(&json["convergence"], &page);
    for name in ["noisy", "reference", "dense", "uniform_zoom", "adaptive_centres", "adaptive_ring"] {
        let png = image::open(folder.path().join(format!("{name}.png"))).unwrap();
        let size = if name.ends_with("zoom") { (480, 240) } else { (64, 36) };
        assert_eq!((png.width(), png.height()), size, "{name}");
    }
}

fn check_convergence(convergence: &Value, page: &str) {
    assert_eq!(convergence["frames"], serde_json::json!([1, 2, 4, 6]));
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    let methods = convergence["methods"].as_array().unwrap();
    let names: Vec<_> = methods.iter().map(|method| method["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["quell", "models_alone", "accumulate"]);
    let mse = |method: usize, at: usize| number(&methods[method]["mse"][at]);
    for at in 0..4 {
        let cells = (0..3).map(|method| format!("<td>{:.3}</td>", 1e3 * mse(method, at)));
        let row = format!("<td>{}</td>{}", convergence["frames"][at], cells.collect::<String>());
        assert!(page.contains(&row), "{row}");
        assert!(mse(0, at) < mse(2, at), "less than without denoising");
    }
    assert!((0..3).all(|method| mse(method, 3) < mse(method, 0)), "{methods:?}");

    let stillness = &convergence["stillness"];
    assert_eq!((&stillness["first_frame"], &stillness["last_frame"]), (&4.into(), &6.into()));
    for variance in stillness["methods"].as_array().unwrap() {
        let (pixels, blurred) = (number(&variance["variance"]), number(&variance["blurred"]));
        assert!(0.0 < blurred && blurred < pixels, "{variance}");
    }
    for ratio in ["innovation_ratio", "innovation_blurred_ratio"] {
        assert!(page.contains(&format!("<td>{:.3}</td>", number(&stillness[ratio]))), "{ratio}");
    }
}

#[test]
fn a_study_can_leave_convergence_out() {
    let folder = tempfile::tempdir().unwrap();
    let less = ["study", "--size", "32x18", "--spp", "1", "--reference", "2", "--runs", "1", "--frames", "0"];
    assert_succeeds(&demo(&[&less[..], &["--out", folder.path().to_str().unwrap()]].concat()));
    let page = std::fs::read_to_string(folder.path().join("study.html")).unwrap();
    assert!(page.contains("id=\"curves\"") && !page.contains("id=\"convergence\"") && !page.contains("{{"));
    let json = std::fs::read_to_string(folder.path().join("study.json")).unwrap();
    assert!(serde_json::from_str::<Value>(&json).unwrap()["convergence"].is_null());
}

#[test]
fn a_study_explains_wrong_options() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let image = "the image has 64x36 pixels";
    for (arguments, code, parts) in [
        (&["--pixels", "10,10", "64,3"][..], 1, &["pixel 64,3 is outside", image][..]),
        (&["--pixels", "10"], 2, &["--pixels", "X,Y", "160,90"]),
        (&["--pixels", "10,-1"], 2, &["10,-1", "X,Y"]),
        (&["--zoom", "60,0,5,5"], 1, &["zoom 60,0,5,5 does not fit", image]),
        (&["--zoom", "0,0,0,5"], 1, &["zoom 0,0,0,5", image]),
        (&["--zoom", "1,2,3"], 2, &["--zoom", "X,Y,WIDTH,HEIGHT"]),
        (&["--scene", "no such scene.glb"], 1, &["error: ", "no such scene.glb"]),
    ] {
        assert_fails(&study(&out, arguments), code, parts);
    }
    // The gallery begins with an arcade, open to the sky on the right.
    assert_fails(&study(&out, &["--pixels", "60,3"]), 1, &["pixel 60,3 sees the sky"]);
    assert!(!out.exists(), "nothing is left behind");
    assert_fails(&demo(&["study", "--reference", "1", "--out", "x"]), 2, &["--reference", "1"]);
    assert_fails(&demo(&["study", "--runs", "0", "--out", "x"]), 2, &["--runs", "1..=1024"]);
    let file = folder.path().join("a file");
    std::fs::write(&file, "").unwrap();
    assert_fails(&study(&file, &[]), 1, &["a file", "cannot create the folder"]);
}
