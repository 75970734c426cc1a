//! A frame as nodes that declare what they read and write. From that follow their order, which of them are needed at all, and how
//! long each texture lives. Built anew in every frame; what outlives a frame belongs to whoever adds the nodes.

use super::pool::{Key, Pool};
use anyhow::{Context, ensure};
use std::collections::{HashMap, HashSet};
use thiserror::Error;
use wgpu::{CommandEncoder, TextureFormat, TextureUsages, TextureView};

pub type Name = &'static str;

/// A texture that exists from the node that creates it to the last one that reads it.
#[derive(Debug, Clone, Copy)]
pub struct Transient {
    pub format: TextureFormat,
    pub usage: TextureUsages,
    /// How often smaller than the view it is, on each side.
    pub shrink: u32,
}

type Record<'a> = dyn FnOnce(&mut CommandEncoder, &Textures) -> anyhow::Result<()> + 'a;

pub struct Node<'a> {
    name: Name,
    reads: Vec<Name>,
    creates: Vec<(Name, Transient)>,
    writes: Vec<Name>,
    record: Box<Record<'a>>,
}

impl<'a> Node<'a> {
    pub fn new(
        name: Name,
        record: impl FnOnce(&mut CommandEncoder, &Textures) -> anyhow::Result<()> + 'a,
    ) -> Self {
        Self { name, reads: vec![], creates: vec![], writes: vec![], record: Box::new(record) }
    }

    /// Textures that other nodes create.
    pub fn reads(mut self, textures: &[Name]) -> Self {
        self.reads.extend(textures);
        self
    }

    /// A transient texture that this node fills.
    pub fn creates(mut self, texture: Name, transient: Transient) -> Self {
        self.creates.push((texture, transient));
        self
    }

    /// An imported texture. Only what these need is recorded.
    pub fn writes(mut self, texture: Name) -> Self {
        self.writes.push(texture);
        self
    }
}

/// What is wrong with the nodes.
#[derive(Debug, PartialEq, Error)]
pub enum GraphError {
    #[error("node `{node}` reads `{texture}`, which no node creates")]
    NoProducer { node: Name, texture: Name },
    #[error("nodes `{first}` and `{second}` both create `{texture}`")]
    TwoProducers { texture: Name, first: Name, second: Name },
    #[error("node `{node}` writes `{texture}`, which is not imported")]
    NotImported { node: Name, texture: Name },
    #[error("nodes wait for each other: {}", .nodes.join(" > "))]
    Cycle { nodes: Vec<Name> },
}

/// The nodes that are needed, in order, each with the textures that nobody needs after it.
#[derive(Debug, PartialEq)]
pub struct Plan {
    pub steps: Vec<(usize, Vec<Name>)>,
}

#[derive(Default)]
pub struct Graph<'a> {
    nodes: Vec<Node<'a>>,
    imported: HashMap<Name, &'a TextureView>,
}

/// The textures that a node declared.
#[derive(Default)]
pub struct Textures<'a> {
    transient: HashMap<Name, (Key, TextureView)>,
    imported: HashMap<Name, &'a TextureView>,
    declared: HashSet<Name>,
}

impl Textures<'_> {
    pub fn get(&self, name: Name) -> anyhow::Result<&TextureView> {
        // Others may exist, but nobody would keep them.
        ensure!(self.declared.contains(name), "does not declare `{name}`");
        let transient = self.transient.get(name).map(|(_, view)| view);
        transient.or(self.imported.get(name).copied()).with_context(|| format!("there is no `{name}`"))
    }
}

impl<'a> Graph<'a> {
    /// A texture from outside, for nodes to write.
    pub fn import(&mut self, name: Name, view: &'a TextureView) {
        self.imported.insert(name, view);
    }

    pub fn add(&mut self, node: Node<'a>) {
        self.nodes.push(node);
    }

    /// Names of the nodes that the plan records, in order.
    pub fn order(&self, plan: &Plan) -> Vec<Name> {
        plan.steps.iter().map(|(node, _)| self.nodes[*node].name).collect()
    }

    /// Names of the nodes whose output nobody reads.
    pub fn culled(&self, plan: &Plan) -> Vec<Name> {
        let order = self.order(plan);
        self.nodes.iter().map(|node| node.name).filter(|name| !order.contains(name)).collect()
    }

    pub fn compile(&self) -> Result<Plan, GraphError> {
        let producers = self.producers()?;
        let mut search = Search { nodes: &self.nodes, producers: &producers, path: vec![], order: vec![] };
        for (i, node) in self.nodes.iter().enumerate() {
            if let Some(texture) = node.writes.iter().find(|texture| !self.has_imported(texture)) {
                return Err(GraphError::NotImported { node: node.name, texture });
            }
            if !node.writes.is_empty() {
                search.visit(i)?;
            }
        }
        // From the end, the first to touch a texture is the last to need it.
        let mut alive: HashSet<Name> = HashSet::new();
        let mut steps = vec![];
        for node in search.order.into_iter().rev() {
            let Node { reads, creates, .. } = &self.nodes[node];
            let touched = reads.iter().copied().chain(creates.iter().map(|(texture, _)| *texture));
            steps.push((node, touched.filter(|texture| alive.insert(texture)).collect()));
        }
        steps.reverse();
        Ok(Plan { steps })
    }

    /// Records the nodes of a view of this size. Textures come from the pool and go back to it as soon as nobody needs them, so
    /// that later nodes and other views get the same ones.
    pub fn record(
        self,
        plan: Plan,
        size: [u32; 2],
        pool: &mut Pool<TextureView>,
        device: &wgpu::Device,
        encoder: &mut CommandEncoder,
    ) -> anyhow::Result<()> {
        let mut textures = Textures { imported: self.imported, ..Textures::default() };
        let mut nodes: Vec<_> = self.nodes.into_iter().map(Some).collect();
        for (node, last_needed) in plan.steps {
            let node = nodes[node].take().context("a node is planned twice")?;
            let Node { name, reads, creates, writes, record } = node;
            textures.declared =
                reads.into_iter().chain(writes).chain(creates.iter().map(|&(t, _)| t)).collect();
            for (texture, Transient { format, usage, shrink }) in creates {
                let key = Key { size: size.map(|side| side.div_ceil(shrink)), format, usage };
                textures.transient.insert(texture, (key, pool.acquire(key, || key.create(device))));
            }
            record(encoder, &textures).with_context(|| format!("node `{name}`"))?;
            for texture in last_needed {
                let (key, view) = textures.transient.remove(texture).context("a texture is freed twice")?;
                pool.release(key, view);
            }
        }
        Ok(())
    }

    fn has_imported(&self, texture: Name) -> bool {
        self.imported.contains_key(texture)
    }

    /// The node that creates each texture.
    fn producers(&self) -> Result<HashMap<Name, usize>, GraphError> {
        let mut producers = HashMap::new();
        for (i, node) in self.nodes.iter().enumerate() {
            for (texture, _) in &node.creates {
                if let Some(first) = producers.insert(*texture, i) {
                    let [first, second] = [first, i].map(|node| self.nodes[node].name);
                    return Err(GraphError::TwoProducers { texture, first, second });
                }
            }
        }
        Ok(producers)
    }
}

/// Depth first: a node comes after all that it reads from.
struct Search<'s, 'a> {
    nodes: &'s [Node<'a>],
    producers: &'s HashMap<Name, usize>,
    /// From a root to the node that is being visited.
    path: Vec<usize>,
    order: Vec<usize>,
}

impl Search<'_, '_> {
    fn visit(&mut self, node: usize) -> Result<(), GraphError> {
        if self.order.contains(&node) {
            return Ok(());
        }
        if let Some(start) = self.path.iter().position(|on_path| *on_path == node) {
            let cycle = self.path[start..].iter().chain([&node]).map(|node| self.nodes[*node].name);
            return Err(GraphError::Cycle { nodes: cycle.collect() });
        }
        self.path.push(node);
        let Node { name, ref reads, .. } = self.nodes[node];
        for texture in reads {
            let producer = self.producers.get(texture);
            self.visit(*producer.ok_or(GraphError::NoProducer { node: name, texture })?)?;
        }
        self.path.pop();
        self.order.push(node);
        Ok(())
    }
}
