//! systemd's logind deletes what a normal user has in /dev/shm when the user's last session ends,
//! unless its configuration or the user's says otherwise: `RemoveIPC` in logind.conf(5).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Where logind is configured, the strongest first.
const PLACES: [&str; 4] = ["etc", "run", "usr/local/lib", "usr/lib"];

/// Largest id of a system user where login.defs(5) does not say.
const SYSTEM_UID_MAX: u32 = 999;

/// Largest file that is read. [bytes]
const FILE_BYTES_MAX: u64 = 1 << 20;

/// What decides about the caller's shared memory.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Facts {
    /// True when logind is there.
    pub runs: bool,
    /// `RemoveIPC`, and the file that says so; `None` is the built-in default, which is yes.
    pub removes: Option<(bool, PathBuf)>,
    /// The caller.
    pub uid: u32,
    /// The caller's name; its id when that has none.
    pub user: String,
    /// Largest id of a system user, whose memory is spared.
    pub system_uid_max: u32,
    /// True when the caller's sessions never end (`loginctl enable-linger`).
    pub lingers: bool,
}

impl Facts {
    /// The facts of this machine and user.
    pub(crate) fn read() -> Self {
        Self::below(Path::new("/"), rustix::process::geteuid().as_raw())
    }

    /// The facts in the file system below `root`.
    fn below(root: &Path, uid: u32) -> Self {
        let user = text(&root.join("etc/passwd"))
            .as_deref()
            .and_then(|passwd| user_name(passwd, uid))
            .unwrap_or_else(|| uid.to_string());
        let defaults = text(&root.join("etc/login.defs")).unwrap_or_default();
        Self {
            runs: root.join("run/systemd/users").is_dir(),
            removes: setting(&configuration(root)),
            lingers: root.join("var/lib/systemd/linger").join(&user).exists(),
            uid,
            user,
            system_uid_max: system_uid_max(&defaults),
        }
    }

    /// True when the caller's shared memory is deleted at logout.
    pub(crate) fn are_a_danger(&self) -> bool {
        let removes = self.removes.as_ref().is_none_or(|(removes, _)| *removes);
        self.runs && removes && self.uid > self.system_uid_max && !self.lingers
    }
}

/// Name of the user with this id.
fn user_name(passwd: &str, uid: u32) -> Option<String> {
    let mut users = passwd.lines().map(|line| line.split(':'));
    let name = users.find_map(|mut fields| {
        let name = fields.next()?;
        (fields.nth(1)?.parse() == Ok(uid)).then_some(name)
    })?;
    // A name that leads elsewhere as a file name is none.
    let is_plain = !name.is_empty() && !name.starts_with('.') && !name.contains('/');
    is_plain.then(|| name.to_owned())
}

/// `SYS_UID_MAX` of login.defs.
fn system_uid_max(login_defs: &str) -> u32 {
    let mut lines = login_defs.lines().map(str::split_whitespace);
    let found = lines.find_map(|mut words| {
        (words.next()? == "SYS_UID_MAX").then(|| words.next()?.parse().ok())?
    });
    found.unwrap_or(SYSTEM_UID_MAX)
}

/// The texts of logind's configuration in the order in which later ones win.
fn configuration(root: &Path) -> Vec<(PathBuf, String)> {
    let places = PLACES.map(|place| root.join(place).join("systemd"));
    let main = places.iter().find_map(|place| {
        let file = place.join("logind.conf");
        text(&file).map(|text| (file, text))
    });
    // Of drop-ins with the same name only that in the strongest place counts; all are read in the
    // order of their names.
    let mut drop_ins: BTreeMap<std::ffi::OsString, PathBuf> = BTreeMap::new();
    for place in &places {
        let entries = std::fs::read_dir(place.join("logind.conf.d"));
        for entry in entries.into_iter().flatten().flatten() {
            if entry.path().extension().is_some_and(|end| end == "conf") {
                drop_ins.entry(entry.file_name()).or_insert(entry.path());
            }
        }
    }
    let drop_ins = drop_ins.into_values();
    let drop_ins = drop_ins.filter_map(|file| text(&file).map(|text| (file, text)));
    main.into_iter().chain(drop_ins).collect()
}

/// `RemoveIPC` by the last text that sets it, and whose text that is.
fn setting(texts: &[(PathBuf, String)]) -> Option<(bool, PathBuf)> {
    let last = |text: &str| assignments(text).into_iter().next_back();
    texts
        .iter()
        .rev()
        .find_map(|(file, text)| last(text).map(|removes| (removes, file.clone())))
}

/// Every usable assignment to `RemoveIPC` in the section `[Login]`, in order.
fn assignments(text: &str) -> Vec<bool> {
    let mut found = Vec::new();
    let mut is_login = false;
    for line in text.lines().map(str::trim) {
        if line.starts_with(['#', ';']) {
            continue;
        }
        if let Some(section) = line
            .strip_prefix('[')
            .and_then(|line| line.strip_suffix(']'))
        {
            is_login = section == "Login";
            continue;
        }
        let Some((key, value)) = line.split_once('=').filter(|_| is_login) else {
            continue;
        };
        let value = value.trim().to_ascii_lowercase();
        let value = match value.as_str() {
            "1" | "yes" | "y" | "true" | "t" | "on" => Some(true),
            "0" | "no" | "n" | "false" | "f" | "off" => Some(false),
            _ => None,
        };
        found.extend(value.filter(|_| key.trim() == "RemoveIPC"));
    }
    found
}

/// A file's text; `None` when there is none, when it is too large, or for anything but a file.
fn text(file: &Path) -> Option<String> {
    let metadata = std::fs::metadata(file).ok()?;
    let bytes = (metadata.is_file() && metadata.len() <= FILE_BYTES_MAX)
        .then(|| std::fs::read(file).ok())??;
    Some(String::from_utf8_lossy(&bytes).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    type Files<'a> = &'a [(&'a str, &'a str)];

    /// A file system with these files.
    fn root(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a folder");
        for (name, text) in files {
            let file = root.path().join(name);
            std::fs::create_dir_all(file.parent().expect("a folder")).expect("made");
            std::fs::write(file, text).expect("written");
        }
        root
    }

    const PASSWD: (&str, &str) = (
        "etc/passwd",
        "root:x:0:0:root:/root:/bin/bash\nbroken\nrobot:x:1000:1000::/home/robot:/bin/sh\n\
         ../../tmp:x:1001:1001::/:/bin/sh\n",
    );
    const USERS: (&str, &str) = ("run/systemd/users/1000", "");

    #[test]
    fn normal_users_lose_their_memory_by_default() {
        let root = root(&[
            PASSWD,
            USERS,
            ("etc/systemd/logind.conf", "[Login]\n#RemoveIPC=no\n"),
        ]);
        let facts = Facts::below(root.path(), 1000);
        assert_eq!(facts.user, "robot");
        assert_eq!(facts.removes, None);
        assert!(facts.are_a_danger());
        assert!(
            !Facts::below(root.path(), 0).are_a_danger(),
            "a system user"
        );
        assert!(
            !Facts::below(root.path(), 999).are_a_danger(),
            "a system user"
        );
    }

    #[test]
    fn without_logind_or_with_lingering_nothing_is_lost() {
        let root1 = root(&[PASSWD]);
        assert!(!Facts::below(root1.path(), 1000).are_a_danger());
        let root2 = root(&[PASSWD, USERS, ("var/lib/systemd/linger/robot", "")]);
        let facts = Facts::below(root2.path(), 1000);
        assert!(facts.lingers);
        assert!(!facts.are_a_danger());
    }

    #[test]
    fn drop_ins_win_by_name_and_the_strongest_place_by_the_same_name() {
        let no = "[Login]\nRemoveIPC=no\n";
        let yes = "[Login]\nRemoveIPC = Yes\n";
        let cases: [(Files<'_>, Option<(bool, &str)>); 4] = [
            (
                &[
                    ("etc/systemd/logind.conf", no),
                    ("usr/lib/systemd/logind.conf", yes),
                ],
                Some((false, "etc/systemd/logind.conf")),
            ),
            (
                &[
                    ("etc/systemd/logind.conf", no),
                    ("usr/lib/systemd/logind.conf.d/10-a.conf", yes),
                ],
                Some((true, "usr/lib/systemd/logind.conf.d/10-a.conf")),
            ),
            (
                &[
                    ("etc/systemd/logind.conf.d/10-a.conf", no),
                    ("usr/lib/systemd/logind.conf.d/10-a.conf", yes),
                    ("run/systemd/logind.conf.d/05-b.conf", yes),
                    ("etc/systemd/logind.conf.d/99-c.disabled", yes),
                ],
                Some((false, "etc/systemd/logind.conf.d/10-a.conf")),
            ),
            (&[("etc/systemd/logind.conf.d", "no folder")], None),
        ];
        for (files, expected) in cases {
            let root = root(&[files, &[PASSWD, USERS]].concat());
            let facts = Facts::below(root.path(), 1000);
            let expected = expected.map(|(removes, file)| (removes, root.path().join(file)));
            assert_eq!(facts.removes, expected);
        }
    }

    #[test]
    fn foreign_text_is_read_as_logind_reads_it() {
        for (text, expected) in [
            ("RemoveIPC=no", vec![]),
            (
                "[Manager]\nRemoveIPC=no\n[Login]\nRemoveIPC=off",
                vec![false],
            ),
            (
                "[Login]\n  RemoveIPC =  TRUE \nRemoveIPC=0",
                vec![true, false],
            ),
            (
                "[Login]\nRemoveIPC=maybe\nRemoveIPC=\n;RemoveIPC=no\nRemoveIPCs=no",
                vec![],
            ),
            ("[Login\nRemoveIPC=no\n\u{0}=\n===", vec![]),
        ] {
            assert_eq!(assignments(text), expected, "{text:?}");
        }
        assert_eq!(
            system_uid_max("#SYS_UID_MAX 5\nSYS_UID_MIN 101\nSYS_UID_MAX\t 499\n"),
            499
        );
        assert_eq!(system_uid_max("SYS_UID_MAX many\n"), SYSTEM_UID_MAX);
        assert_eq!(
            user_name(PASSWD.1, 1001),
            None,
            "a name that leads elsewhere"
        );
        assert_eq!(user_name("a:x\n:x:7:\n", 7), None);
    }
}
