//! The pages say nothing that is not there: links, pictures, commands, options, names of the interface.

use clap::CommandFactory;
use quell_demo::cli::Cli;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn pages() -> Vec<PathBuf> {
    let docs = std::fs::read_dir(top().join("demo/docs")).unwrap().map(|entry| entry.unwrap().path());
    let is_page = |path: &PathBuf| path.extension().is_some_and(|extension| extension == "md");
    let readmes = ["README.md", "demo/bevy/README.md"].map(|readme| top().join(readme));
    readmes.into_iter().chain(docs.filter(is_page)).collect()
}

/// What links and pictures point to.
fn links(prose: &str) -> Vec<&str> {
    prose.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0)).collect()
}

/// What stands in backticks.
fn codes(prose: &str) -> Vec<&str> {
    prose.split('`').skip(1).step_by(2).collect()
}

/// The text outside of fenced blocks, and what is in those of a language.
fn prose(text: &str) -> String {
    text.split("```").step_by(2).collect()
}

fn blocks<'a>(text: &'a str, language: &str) -> Vec<&'a str> {
    text.split("```").skip(1).step_by(2).filter_map(|block| block.strip_prefix(language)).collect()
}

/// As GitHub makes anchors of headings.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings =
        prose(text).lines().filter_map(|line| Some(line.strip_prefix('#')?.to_owned())).collect::<Vec<_>>();
    let slug = |heading: &String| {
        let kept = |c: &char| c.is_alphanumeric() || " -_".contains(*c);
        heading
            .trim_start_matches('#')
            .trim()
            .to_lowercase()
            .chars()
            .filter(kept)
            .collect::<String>()
            .replace(' ', "-")
    };
    headings.iter().map(slug).collect()
}

fn broken_links(page: &Path, text: &str) -> Vec<String> {
    let mut broken = vec![];
    for link in links(&prose(text)) {
        if link.contains("://") {
            continue;
        }
        let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
        let target = if file.is_empty() { page.to_owned() } else { page.parent().unwrap().join(file) };
        if !file.is_empty() && !target.exists() {
            broken.push(format!("{}: nothing at {link}", page.display()));
        } else if !anchor.is_empty() {
            let other =
                if file.is_empty() { text.to_owned() } else { std::fs::read_to_string(&target).unwrap() };
            if !anchors(&other).contains(anchor) {
                broken.push(format!("{}: no heading {link}", page.display()));
            }
        }
    }
    broken
}

/// Commands that run the demo, with what a shell would do to them undone as far as is needed here.
fn commands(text: &str) -> Vec<Vec<String>> {
    let mut found = vec![];
    for block in blocks(text, "sh\n") {
        for line in block.replace("\\\n", " ").lines() {
            let Some((_, arguments)) = line.split_once("demo/run.sh") else { continue };
            let arguments = arguments.split(['#', ';']).next().unwrap();
            // What a variable holds can be anything.
            if !arguments.contains(['$', '{']) {
                found.push(arguments.split_whitespace().map(str::to_owned).collect());
            }
        }
    }
    found
}

/// Of the examples, which have command lines of their own.
const EXAMPLES_OPTIONS: [&str; 4] = ["mistake", "wrong", "effect", "ignore-rust-version"];

fn wrong_commands(page: &Path, text: &str) -> Vec<String> {
    let mut wrong = vec![];
    for arguments in commands(text) {
        let whole = std::iter::once("quell-demo".to_owned()).chain(arguments.clone());
        if let Err(error) = Cli::command().try_get_matches_from(whole)
            && error.kind() != clap::error::ErrorKind::DisplayHelp
        {
            wrong.push(format!("{}: {}: {error}", page.display(), arguments.join(" ")));
        }
    }
    let all = Cli::command();
    let options: BTreeSet<_> = std::iter::once(&all)
        .chain(all.get_subcommands())
        .flat_map(|command| command.get_arguments().filter_map(|argument| argument.get_long()))
        .chain(EXAMPLES_OPTIONS)
        .collect();
    for code in codes(&prose(text)).into_iter().filter(|code| !code.contains("cargo")) {
        for option in code.split_whitespace().filter_map(|word| word.strip_prefix("--")) {
            if !options.contains(option) {
                wrong.push(format!("{}: no option --{option}", page.display()));
            }
        }
    }
    wrong
}

/// `Type::name` in backticks, where the type is one of the library's.
fn unknown_names(page: &Path, text: &str, sources: &[String]) -> Vec<String> {
    let mut unknown = vec![];
    for code in codes(&prose(text)) {
        let Some((kind, name)) = code.split_once("::") else { continue };
        let name: String = name.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let is_home = |source: &&String| {
            ["struct", "enum", "trait"].iter().any(|word| {
                [" ", "<", "(", ";"].iter().any(|end| source.contains(&format!("pub {word} {kind}{end}")))
            })
        };
        if let Some(source) = sources.iter().find(is_home) {
            let is_there = source.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == name);
            if !is_there {
                unknown.push(format!("{}: `{code}` is not in the library", page.display()));
            }
        }
    }
    unknown
}

fn sources() -> Vec<String> {
    let mut folders = vec![top().join("src"), top().join("demo/bevy/src")];
    let mut sources = vec![];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                sources.push(std::fs::read_to_string(path).unwrap());
            }
        }
    }
    sources
}

#[test]
fn links_commands_and_names_are_there() {
    let sources = sources();
    let mut problems = vec![];
    for page in pages() {
        let text = std::fs::read_to_string(&page).unwrap();
        problems.extend(broken_links(&page, &text));
        problems.extend(wrong_commands(&page, &text));
        problems.extend(unknown_names(&page, &text, &sources));
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The README shows the plugin as its own page does, where it is compiled.
#[test]
fn the_plugin_is_shown_as_it_is_compiled() {
    let [readme, page] =
        ["README.md", "demo/bevy/README.md"].map(|file| std::fs::read_to_string(top().join(file)).unwrap());
    let code = blocks(&page, "rust,no_run\n");
    assert_eq!(code.len(), 1);
    assert!(blocks(&readme, "rust,ignore\n").contains(&code[0]), "README.md lacks:\n{}", code[0]);
}

#[test]
fn what_is_not_there_is_found() {
    let page = top().join("demo/docs/invented.md");
    let links = "# A Heading: of two\n[a](README.md) [b](nowhere.md) [c](#a-heading-of-two) [d](#another) ![e](no.png)";
    let broken = broken_links(&page, links);
    assert_eq!(broken.len(), 3, "{broken:?}");
    assert!(
        broken[0].contains("nowhere.md") && broken[1].contains("#another") && broken[2].contains("no.png")
    );

    let shell = "`--jitter` `--jiter`\n```sh\n./demo/run.sh render --out a # pictures\n./demo/run.sh reorder --out a\n./demo/run.sh help still\n```\n";
    let wrong = wrong_commands(&page, shell);
    assert_eq!(wrong.len(), 2, "{wrong:?}");
    assert!(wrong[0].contains("reorder") && wrong[1].contains("--jiter"));

    let names = "`Settings::max_history`, `Settings::least_history`, `DebugView::Windows`, `DebugView::Doors`, `wgpu::Device`";
    let unknown = unknown_names(&page, names, &sources());
    assert_eq!(unknown.len(), 2, "{unknown:?}");
    assert!(unknown[0].contains("least_history") && unknown[1].contains("Doors"));
}

/// All pictures together stay small enough to be kept with the code, and none is left over.
#[test]
fn pictures_are_small_and_used() {
    let text: String = pages().iter().map(|page| std::fs::read_to_string(page).unwrap()).collect();
    let mut total = 0;
    for entry in std::fs::read_dir(top().join("demo/docs/pictures")).unwrap() {
        let (path, bytes) = entry.map(|entry| (entry.path(), entry.metadata().unwrap().len())).unwrap();
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(text.contains(&format!("pictures/{name}")), "no page shows {name}");
        assert!(bytes < 150_000, "{name} has {bytes} bytes");
        total += bytes;
    }
    assert!(total < 2_000_000, "pictures have {total} bytes");
}

/// As the page on integration says.
#[test]
fn denoisers_may_go_to_other_threads() {
    fn is_shared<T: Send + Sync>() {}
    is_shared::<quell::Denoiser>();
    is_shared::<quell::Pipelines>();
    is_shared::<quell::Settings>();
    is_shared::<quell::FrameOutputs>();
    is_shared::<quell::FrameError>();
    is_shared::<quell::CreateError>();
}
