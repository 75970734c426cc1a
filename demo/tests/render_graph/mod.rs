//! The graph of the example `render_graph`, without its nodes.

#[allow(dead_code, reason = "a part of the example")]
#[path = "../../examples/render_graph/graph.rs"]
mod graph;
#[path = "../../examples/render_graph/pool.rs"]
mod pool;

use graph::{Graph, GraphError, Name, Node, Transient};
use pool::{Counts, Key, Pool};
use quell_demo::gpu::Gpu;
use wgpu::{TextureFormat as Format, TextureUsages as Usages, TextureView};

const TRANSIENT: Transient =
    Transient { format: Format::Rgba16Float, usage: Usages::STORAGE_BINDING, shrink: 1 };

fn node(name: Name, reads: &[Name], creates: &[Name]) -> Node<'static> {
    let node = Node::new(name, |_, _| Ok(())).reads(reads);
    creates.iter().fold(node, |node, texture| node.creates(texture, TRANSIENT))
}

fn show(reads: &[Name]) -> Node<'static> {
    node("show", reads, &[]).writes("screen")
}

fn graph<'a>(screen: &'a TextureView, nodes: impl IntoIterator<Item = Node<'a>>) -> Graph<'a> {
    let mut graph = Graph::default();
    graph.import("screen", screen);
    nodes.into_iter().for_each(|node| graph.add(node));
    graph
}

fn gpu() -> (Gpu, TextureView) {
    let gpu = Gpu::new().expect("tests need a Vulkan driver");
    let key = Key { size: [4, 4], format: Format::Rgba8Unorm, usage: Usages::RENDER_ATTACHMENT };
    let screen = key.create(&gpu.device);
    (gpu, screen)
}

#[test]
fn nodes_come_after_what_they_read_and_only_if_needed() {
    let (_gpu, screen) = gpu();
    let nodes = [
        show(&["lit", "depth"]),
        node("unused", &["lit"], &["debug"]),
        node("light", &["depth", "normal"], &["lit"]),
        node("surface", &[], &["depth", "normal", "motion"]),
    ];
    let graph = graph(&screen, nodes);
    let plan = graph.compile().unwrap();
    assert_eq!(graph.order(&plan), ["surface", "light", "show"]);
    assert_eq!(graph.culled(&plan), ["unused"]);
    // What nobody reads lives as long as its own node.
    let freed: Vec<_> = plan.steps.iter().map(|(_, freed)| freed.as_slice()).collect();
    assert_eq!(freed, [&["motion"][..], &["normal"], &["lit", "depth"]]);
}

#[test]
fn mistakes_are_named() {
    let (_gpu, screen) = gpu();
    let error = |nodes: Vec<Node<'static>>| graph(&screen, nodes).compile().unwrap_err();
    assert_eq!(
        error(vec![show(&["lit"]), node("light", &["depth"], &["lit"])]),
        GraphError::NoProducer { node: "light", texture: "depth" }
    );
    let twice = error(vec![show(&["lit"]), node("a", &[], &["lit"]), node("b", &[], &["lit"])]);
    assert_eq!(twice.to_string(), "nodes `a` and `b` both create `lit`");
    let nodes = vec![
        show(&["c"]),
        node("blur", &["b"], &["c"]),
        node("light", &["a"], &["b"]),
        node("feedback", &["b"], &["a"]),
    ];
    assert_eq!(error(nodes).to_string(), "nodes wait for each other: light > feedback > light");
    let alone = error(vec![show(&["a"]), node("self", &["a"], &["a"])]);
    assert_eq!(alone.to_string(), "nodes wait for each other: self > self");
    let elsewhere = error(vec![node("show", &[], &[]).writes("window")]);
    assert_eq!(elsewhere.to_string(), "node `show` writes `window`, which is not imported");
}

#[test]
fn textures_are_recycled_within_a_view_over_views_and_over_frames() {
    let (gpu, screen) = gpu();
    let mut pool = Pool::default();
    let mut frame = |size| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        for _view in 0..2 {
            let nodes = [
                node("surface", &[], &["depth"]),
                node("light", &["depth"], &["lit"]),
                node("blur", &["lit"], &["blurred"]),
                show(&["blurred"]),
            ];
            let graph = graph(&screen, nodes);
            let plan = graph.compile().unwrap();
            graph.record(plan, size, &mut pool, &gpu.device, &mut encoder).unwrap();
        }
        gpu.queue.submit([encoder.finish()]);
        pool.end_frame()
    };
    assert_eq!(frame([8, 8]), Counts { created: 2, recycled: 4, dropped: 0, held: 2 });
    assert_eq!(frame([8, 8]), Counts { created: 0, recycled: 6, dropped: 0, held: 2 });
    // Another size: new ones, and the old ones go after some frames.
    assert_eq!(frame([9, 8]), Counts { created: 2, recycled: 4, dropped: 0, held: 4 });
    assert_eq!(frame([9, 8]), Counts { created: 0, recycled: 6, dropped: 2, held: 2 });
}

#[test]
fn what_lives_at_once_is_never_one_texture() {
    let (gpu, screen) = gpu();
    let use_both = Node::new("light", |_, textures| {
        assert_ne!(textures.get("depth")?.texture(), textures.get("lit")?.texture());
        Ok(())
    });
    let use_both = use_both.reads(&["depth"]).creates("lit", TRANSIENT);
    let graph = graph(&screen, [node("surface", &[], &["depth"]), use_both, show(&["lit"])]);
    let plan = graph.compile().unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    graph.record(plan, [8, 8], &mut Pool::default(), &gpu.device, &mut encoder).unwrap();
}

#[test]
fn a_node_gets_only_what_it_declares() {
    let (gpu, screen) = gpu();
    let curious = Node::new("curious", |_, textures| textures.get("depth").map(|_| ()));
    let nodes = [node("surface", &[], &["depth"]), curious.writes("screen"), show(&["depth"])];
    let graph = graph(&screen, nodes);
    let plan = graph.compile().unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let error = graph.record(plan, [8, 8], &mut Pool::default(), &gpu.device, &mut encoder).unwrap_err();
    assert_eq!(format!("{error:#}"), "node `curious`: does not declare `depth`");
}

#[test]
fn only_equal_textures_are_recycled() {
    let mut pool = Pool::default();
    let key = Key { size: [8, 8], format: Format::Rgba8Unorm, usage: Usages::STORAGE_BINDING };
    let others = [
        Key { size: [8, 9], ..key },
        Key { format: Format::Rgba16Float, ..key },
        Key { usage: Usages::RENDER_ATTACHMENT, ..key },
    ];
    pool.release(key, 1);
    for other in others {
        assert_eq!(pool.acquire(other, || 2), 2);
    }
    assert_eq!(pool.acquire(key, || 2), 1);
    assert_eq!(pool.acquire(key, || 2), 2);
}
