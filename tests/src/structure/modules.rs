//! Module trees, which file uses which, and the circles among them.
//!
//! A file uses another one when its code or a `use` line names an item that lives there. The path is
//! followed through re-exports to the file that declares the item, so a `mod.rs` that only
//! re-exports is never part of a circle. These are no uses:
//!
//! - `mod child;`: a parent has to declare its children;
//! - `pub use child::Item;` in a parent whose own code does not name `Item`: it only exports it;
//! - importing a module (`use super::child;`): what counts are the paths that begin with it;
//! - everything under `#[cfg(test)]`: a test may look at all of its crate.
//!
//! Methods and fields are not seen, because their names do not say where they are declared.

use super::paths::{self, Import, Named};
use super::tokens;
use proc_macro2::TokenTree;
use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// What each uses of the others.
type Uses = [BTreeMap<usize, BTreeSet<String>>];

/// What the paths asked for in one search lead to, by module.
type Seen = HashMap<(usize, Vec<String>), Option<Target>>;

/// Segments of a path that is followed; a longer one comes of imports that name each other.
const SEGMENTS_MAX: usize = 32;

#[derive(Debug)]
struct Module {
    /// Index of its file.
    file: usize,
    parent: Option<usize>,
    children: HashMap<String, usize>,
    named: Named,
}

/// The module tree below one crate root.
#[derive(Debug)]
pub struct Crate {
    /// Its root: `lib.rs`, `main.rs`, an example, a bench or a test.
    pub root: PathBuf,
    files: Vec<PathBuf>,
    modules: Vec<Module>,
}

/// Every crate of a package: library, binaries, examples, benches and tests.
///
/// # Panics
/// When a source file cannot be read or is no Rust.
#[must_use]
pub fn crates_of(package: &Path) -> Vec<Crate> {
    let mut roots: Vec<PathBuf> = ["src/lib.rs", "src/main.rs"]
        .iter()
        .map(|root| package.join(root))
        .collect();
    for folder in ["src/bin", "examples", "benches", "tests"] {
        for entry in std::fs::read_dir(package.join(folder))
            .into_iter()
            .flatten()
        {
            let path = entry.expect("an entry of a folder").path();
            roots.push(if path.is_dir() {
                path.join("main.rs")
            } else {
                path
            });
        }
    }
    roots.retain(|root| root.is_file() && root.extension().is_some_and(|end| end == "rs"));
    roots.sort();
    roots.iter().map(|root| Crate::read(root)).collect()
}

impl Crate {
    /// Reads the module tree below a crate root.
    ///
    /// # Panics
    /// When a source file cannot be read, is no Rust, or declares a child without a file.
    #[must_use]
    pub fn read(root: &Path) -> Self {
        let mut this = Self {
            root: root.to_owned(),
            files: vec![root.to_owned()],
            modules: Vec::new(),
        };
        let folder = root.parent().unwrap_or(Path::new(".")).to_owned();
        this.add(0, None, tokens::of_file(root), &folder);
        this
    }

    /// Adds a module whose children's files lie in `folder`; returns its index.
    fn add(
        &mut self,
        file: usize,
        parent: Option<usize>,
        tokens: Vec<TokenTree>,
        folder: &Path,
    ) -> usize {
        let mut named = paths::read(&tokens::without_tests(tokens));
        let children = std::mem::take(&mut named.children);
        let index = self.modules.len();
        self.modules.push(Module {
            file,
            parent,
            children: HashMap::new(),
            named,
        });
        for (name, path, body) in children {
            let child = if let Some(body) = body {
                self.add(file, Some(index), body, &folder.join(&name))
            } else {
                // A file with a `#[path]` has its children beside it, as a `mod.rs` has.
                let source = match path {
                    Some(path) => self.files[file].with_file_name(path),
                    None => file_of(folder, &name),
                };
                let inner = match source.file_stem() {
                    Some(stem) if stem == name.as_str() => folder.join(&name),
                    _ => source.parent().unwrap_or(folder).to_owned(),
                };
                self.files.push(source.clone());
                let tokens = tokens::of_file(&source);
                self.add(self.files.len() - 1, Some(index), tokens, &inner)
            };
            self.modules[index].children.insert(name, child);
        }
        index
    }

    /// The shortest circle through each file that is in one, unless an earlier one goes through it:
    /// files relative to the folder of the root, with what each uses of the next.
    #[must_use]
    pub fn circles(&self) -> Vec<String> {
        let name = |file: usize| self.relative(file).display().to_string();
        circles(&self.uses(), &name)
    }

    /// The same for the rooms of the crate: a file beside its root, with the folder of its name, or a
    /// folder.
    #[must_use]
    pub fn circles_of_rooms(&self) -> Vec<String> {
        let mut rooms: Vec<String> = Vec::new();
        let room_of: Vec<Option<usize>> = (0..self.files.len())
            .map(|file| {
                if file == 0 {
                    return None;
                }
                let first = self.relative(file).components().next()?;
                let name = Path::new(first.as_os_str()).with_extension("");
                let name = name.display().to_string();
                Some(
                    rooms
                        .iter()
                        .position(|room| *room == name)
                        .unwrap_or_else(|| {
                            rooms.push(name);
                            rooms.len() - 1
                        }),
                )
            })
            .collect();
        let mut uses = vec![BTreeMap::<usize, BTreeSet<String>>::new(); rooms.len()];
        for (file, used) in self.uses().into_iter().enumerate() {
            for (other, items) in used {
                if let (Some(room), Some(next)) = (room_of[file], room_of[other])
                    && room != next
                {
                    uses[room].entry(next).or_default().extend(items);
                }
            }
        }
        circles(&uses, &|room| rooms[room].clone())
    }

    /// A file relative to the folder of the root.
    fn relative(&self, file: usize) -> &Path {
        let folder = self.root.parent().unwrap_or(Path::new("."));
        let path = &self.files[file];
        path.strip_prefix(folder).unwrap_or(path)
    }

    /// For each file the files that it uses, with the names of the items.
    fn uses(&self) -> Vec<BTreeMap<usize, BTreeSet<String>>> {
        let mut uses = vec![BTreeMap::<usize, BTreeSet<String>>::new(); self.files.len()];
        for (index, module) in self.modules.iter().enumerate() {
            let mut targets = Vec::new();
            for import in &module.named.imports {
                let path = import.path.strip_suffix(&["*".to_owned()]);
                match self.follow(index, path.unwrap_or(&import.path), &mut Seen::new()) {
                    Some(target) if target.is_module && path.is_none() => {}
                    Some(target) if self.is_only_exported(index, import, &target) => {}
                    Some(target) => targets.push((target, import.name.clone())),
                    None => {}
                }
            }
            for path in &module.named.paths {
                if let Some(target) = self.follow(index, path, &mut Seen::new()) {
                    targets.push((target, path.last().cloned().unwrap_or_default()));
                }
            }
            for (target, name) in targets {
                let used = self.modules[target.module].file;
                if used != module.file {
                    let name = if name.is_empty() {
                        "*".to_owned()
                    } else {
                        name
                    };
                    uses[module.file].entry(used).or_default().insert(name);
                }
            }
        }
        uses
    }

    /// True for a `pub use` of something below the module that its own code does not name.
    fn is_only_exported(&self, index: usize, import: &Import, target: &Target) -> bool {
        let mut above = Some(target.module);
        while above.is_some() && above != Some(index) {
            above = above.and_then(|module| self.modules[module].parent);
        }
        let own_words = &self.modules[index].named.words;
        import.exported && above == Some(index) && !own_words.contains(&import.name)
    }

    /// Where the item that `path` names in module `index` is declared; `None` outside this crate.
    fn follow(&self, index: usize, path: &[String], seen: &mut Seen) -> Option<Target> {
        let (first, rest) = path.split_first()?;
        match first.as_str() {
            "crate" => self.descend(0, rest, seen),
            "self" => self.descend(index, rest, seen),
            "super" => {
                let parent = self.modules[index].parent?;
                match rest.first().map(String::as_str) {
                    Some("super") => self.follow(parent, rest, seen),
                    _ => self.descend(parent, rest, seen),
                }
            }
            _ => self.lookup(index, path, seen),
        }
    }

    /// The item `path` inside the module `index`, or the module itself.
    fn descend(&self, index: usize, path: &[String], seen: &mut Seen) -> Option<Target> {
        if path.is_empty() {
            return Some(Target {
                module: index,
                is_module: true,
            });
        }
        // What is found nowhere is declared by a macro of the module.
        self.lookup(index, path, seen).or(Some(Target {
            module: index,
            is_module: false,
        }))
    }

    /// The item that `path` names relative to the module `index`: in a child, declared there,
    /// imported there, or behind one of its globs. What is asked for while it is looked for, by globs
    /// in a circle, is not found that way.
    fn lookup(&self, index: usize, path: &[String], seen: &mut Seen) -> Option<Target> {
        if path.len() > SEGMENTS_MAX {
            return None;
        }
        let asked = (index, path.to_vec());
        if let Some(found) = seen.get(&asked) {
            return *found;
        }
        seen.insert(asked.clone(), None);
        let found = self.search(index, path, seen);
        seen.insert(asked, found);
        found
    }

    fn search(&self, index: usize, path: &[String], seen: &mut Seen) -> Option<Target> {
        let (first, rest) = path.split_first()?;
        let module = &self.modules[index];
        if let Some(child) = module.children.get(first) {
            return self.descend(*child, rest, seen);
        }
        if module.named.items.contains(first) {
            return Some(Target {
                module: index,
                is_module: false,
            });
        }
        for import in &module.named.imports {
            let glob = import.path.strip_suffix(&["*".to_owned()]);
            if let (Some(from), false) = (glob, first == "*") {
                let Some(target) = self.follow(index, from, seen) else {
                    continue;
                };
                if target.is_module
                    && target.module != index
                    && let Some(found) = self.lookup(target.module, path, seen)
                {
                    return Some(found);
                }
            } else if import.name == *first && import.path.first() != Some(first) {
                let whole: Vec<String> = import.path.iter().chain(rest).cloned().collect();
                return self.follow(index, &whole, seen);
            }
        }
        None
    }
}

/// What a path leads to.
#[derive(Debug, Clone, Copy)]
struct Target {
    /// The module that declares it, or the module itself.
    module: usize,
    is_module: bool,
}

/// The file of a child module.
fn file_of(folder: &Path, name: &str) -> PathBuf {
    let file = folder.join(format!("{name}.rs"));
    if file.is_file() {
        return file;
    }
    folder.join(name).join("mod.rs")
}

/// The shortest circle through each that is in one, unless an earlier one goes through it, with what
/// each uses of the next.
fn circles(uses: &Uses, name: &dyn Fn(usize) -> String) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let mut circles = Vec::new();
    for start in 0..uses.len() {
        if taken.contains(&start) {
            continue;
        }
        let Some(circle) = shortest_circle(start, uses) else {
            continue;
        };
        taken.extend(circle.iter().copied());
        let mut text = String::new();
        for (at, &from) in circle.iter().enumerate() {
            let next = circle[(at + 1) % circle.len()];
            let items: Vec<&str> = uses[from][&next].iter().map(String::as_str).collect();
            let _ = write!(text, "{} -({})-> ", name(from), items.join(", "));
        }
        circles.push(text + &name(circle[0]));
    }
    circles
}

/// The shortest circle of uses through `start`, beginning there.
fn shortest_circle(start: usize, uses: &Uses) -> Option<Vec<usize>> {
    let mut before: HashMap<usize, usize> = HashMap::new();
    let mut queue = VecDeque::from([start]);
    while let Some(file) = queue.pop_front() {
        for &next in uses[file].keys() {
            if next == start {
                let mut circle = vec![file];
                while let Some(previous) = before.get(circle.last()?) {
                    circle.push(*previous);
                }
                circle.reverse();
                return Some(circle);
            }
            if next != start && !before.contains_key(&next) {
                before.insert(next, file);
                queue.push_back(next);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests;
