//! A domain with all topics inside one process.

use zeronav_msgs::role::Role;
use zeronav_shell::peer::Topics;
use zeronav_shell::{Domain, Peer};

/// A domain with all topics. Fields drop in this order.
pub(crate) struct House {
    topics: Option<Topics>,
    launch: Option<Peer>,
}

impl House {
    pub(crate) fn new() -> Self {
        let launch =
            Peer::join(Domain::create().expect("a domain"), Role::Launch, 1).expect("launch joins");
        let topics = launch.create_topics().expect("topics");
        Self {
            topics: Some(topics),
            launch: Some(launch),
        }
    }

    pub(crate) fn root(&self) -> std::path::PathBuf {
        self.launch
            .as_ref()
            .expect("launch")
            .domain()
            .root()
            .to_owned()
    }

    pub(crate) fn join(&self, role: Role, epoch: u32) -> Peer {
        Peer::join(Domain::join(&self.root()).expect("the domain"), role, epoch).expect("a peer")
    }
}

impl Drop for House {
    fn drop(&mut self) {
        drop(self.topics.take());
        if let Some(launch) = self.launch.take() {
            let root = launch.domain().root().to_owned();
            let _ = launch.leave().close();
            assert!(
                !root.exists() || std::thread::panicking(),
                "{} is left",
                root.display()
            );
        }
    }
}
