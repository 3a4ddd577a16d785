//! Nodes of a search, one per cell, reused from search to search.

/// A node counts only when it carries the number of the current search, its generation, so nodes
/// are not cleared between searches.
#[derive(Debug)]
pub(crate) struct NodePool<N> {
    pub(crate) nodes: Vec<N>,
    pub(crate) generation: u32,
}

impl<N> Default for NodePool<N> {
    fn default() -> Self {
        Self {
            nodes: Vec::new(),
            generation: 0,
        }
    }
}

impl<N: Copy + Default> NodePool<N> {
    /// Begins a search over `n_nodes` nodes whose generation has `bits` bits.
    pub(crate) fn begin(&mut self, n_nodes: usize, bits: u32) {
        if self.nodes.len() != n_nodes || self.generation == u32::MAX >> (32 - bits) {
            self.nodes = vec![N::default(); n_nodes];
            self.generation = 0;
        }
        self.generation += 1;
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<N>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_are_cleared_when_the_size_changes_or_the_generations_run_out() {
        let mut pool = NodePool::<u32>::default();
        for generation in 1..=3 {
            pool.begin(4, 2);
            assert_eq!(pool.generation, generation);
            pool.nodes[0] = generation;
        }
        pool.begin(4, 2);
        assert_eq!((pool.generation, pool.nodes[0]), (1, 0));
        pool.nodes[0] = 1;
        pool.begin(9, 2);
        assert_eq!((pool.generation, pool.nodes.as_slice()), (1, &[0; 9][..]));
    }
}
