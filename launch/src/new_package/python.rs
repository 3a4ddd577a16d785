//! A package in Python: one module, and a command that `pip` installs.

use super::name::Name;
use super::place::Text;
use super::sources::Sources;
use super::template::Template;

/// Modules of Python's own, which a module of the same name would not be found for.
const MODULES: &str = "abc aifc argparse array ast asyncio atexit audioop base64 bdb binascii bisect \
    builtins bz2 calendar cgi cgitb chunk cmath cmd code codecs codeop collections colorsys compileall \
    compression concurrent configparser contextlib contextvars copy copyreg crypt csv ctypes curses \
    dataclasses datetime dbm decimal difflib dis distutils doctest email encodings ensurepip enum errno \
    faulthandler fcntl filecmp fileinput fnmatch fractions ftplib functools gc genericpath getopt getpass \
    gettext glob graphlib grp gzip hashlib heapq hmac html http idlelib imaplib imghdr imp importlib \
    inspect io ipaddress itertools json keyword lib2to3 linecache locale logging lzma mailbox mailcap \
    marshal math mimetypes mmap modulefinder multiprocessing netrc nis nntplib ntpath nturl2path numbers \
    operator optparse os ossaudiodev pathlib pdb pickle pickletools pipes pkgutil platform plistlib poplib \
    posix posixpath pprint profile pstats pty pwd py_compile pyclbr pydoc pydoc_data pyexpat queue quopri \
    random re readline reprlib resource rlcompleter runpy sched secrets select selectors shelve shlex \
    shutil signal site smtplib sndhdr socket socketserver spwd sqlite3 ssl stat statistics string \
    stringprep struct subprocess sunau symtable sys sysconfig syslog tabnanny tarfile telnetlib tempfile \
    termios textwrap this threading time timeit tkinter token tokenize tomllib trace traceback \
    tracemalloc tty turtle types typing unicodedata unittest urllib uu uuid venv warnings wave weakref \
    webbrowser wsgiref xdrlib xml xmlrpc zipapp zipfile zipimport zlib zoneinfo";

/// Where `pip` puts the command.
pub(crate) fn binary(name: &Name) -> String {
    format!("./.venv/bin/{}", name.as_str())
}

/// What builds it, in its folder.
pub(crate) const BUILD: &str = "python3 -m venv .venv && .venv/bin/pip install -e .";

/// What git ignores.
pub(crate) const IGNORED: &str = "/.venv\n/runs\n__pycache__/\n*.egg-info/\n";

/// The files.
///
/// # Errors
/// The name is that of a module of Python's own.
pub(crate) fn files(
    template: &Template,
    name: &Name,
    sources: &Sources,
) -> Result<Vec<Text>, String> {
    if MODULES
        .split_whitespace()
        .any(|module| module == name.as_str())
    {
        return Err(format!(
            "`{}` is a module of Python; --name gives another",
            name.as_str()
        ));
    }
    let source = match sources {
        Sources::Folder(root) => format!(
            "file://{}/services/python",
            encoded(&root.to_string_lossy())
        ),
        Sources::Git { url, commit } => {
            let at = commit
                .as_ref()
                .map(|commit| format!("@{commit}"))
                .unwrap_or_default();
            format!("git+{url}{at}#subdirectory=services/python")
        }
    };
    let word = name.as_str();
    let manifest = format!(
        r#"[build-system]
requires = ["setuptools>=68"]
build-backend = "setuptools.build_meta"

[project]
name = "{word}"
version = "0.1.0"
requires-python = ">=3.11"
dependencies = ["zeronav @ {source}"]

[project.scripts]
{word} = "{word}:main"

[tool.setuptools]
py-modules = ["{word}"]
"#
    );
    Ok(vec![
        ("pyproject.toml".into(), manifest),
        (format!("{word}.py").into(), with_main(template, name)),
    ])
}

/// The example's text, with the function that the installed command calls.
fn with_main(template: &Template, name: &Name) -> String {
    let kind = template.type_name(name);
    let last = format!("if __name__ == \"__main__\":\n    run({kind})\n");
    let main = format!(
        "def main():\n    \"\"\"The command `{}`.\"\"\"\n    run({kind})\n\n\n\
         if __name__ == \"__main__\":\n    main()\n",
        name.as_str()
    );
    template.text(name).replace(&last, &main)
}

/// A path as part of an address.
fn encoded(path: &str) -> String {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || b"/-_.~".contains(&byte);
    let letter = |byte| match byte {
        byte if plain(byte) => char::from(byte).to_string(),
        byte => format!("%{byte:02X}"),
    };
    path.bytes().map(letter).collect()
}

#[cfg(test)]
mod tests {
    use super::super::template::{Language, TEMPLATES};
    use super::*;

    #[test]
    fn every_example_gets_the_function_that_is_installed() {
        let name = Name::new("mine").unwrap();
        for template in TEMPLATES
            .iter()
            .filter(|it| it.language == Language::Python)
        {
            assert!(with_main(template, &name).contains("\ndef main():\n"));
        }
    }

    #[test]
    fn a_module_of_python_is_no_name_and_a_path_is_encoded() {
        let name = Name::new("random").unwrap();
        let sources = Sources::find(None).unwrap();
        let template = TEMPLATES
            .iter()
            .find(|it| it.language == Language::Python)
            .unwrap();
        assert!(
            files(template, &name, &sources).is_err_and(|why| why.contains("a module of Python"))
        );
        assert_eq!(encoded("/a b/\u{e4}#"), "/a%20b/%C3%A4%23");
    }
}
