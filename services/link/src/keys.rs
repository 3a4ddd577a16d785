//! Keys and certificates by which two hosts know each other: an authority of their own signs them, and its key is
//! thrown away, so that nobody can sign another one.

use rcgen::{
    BasicConstraints, CertificateParams, DnType, ExtendedKeyUsagePurpose, IsCa, Issuer, KeyPair,
    KeyUsagePurpose,
};
use std::fs::{DirBuilder, OpenOptions};
use std::io::Write;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::Path;

/// A host, and the names and addresses by which others find it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// Its name in the scenario.
    pub host: String,
    /// Names and addresses.
    pub addresses: Vec<String>,
}

impl Named {
    /// Reads `HOST` or `HOST=ADDRESS,...`.
    ///
    /// # Errors
    /// One line naming what is wrong.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (host, addresses) = text.split_once('=').unwrap_or((text, ""));
        let is_one = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_';
        // It names files.
        if host.is_empty() || !host.bytes().all(is_one) || host == "ca" {
            return Err(format!(
                "`{host}` is no name of a host: a to z, 0 to 9 and _"
            ));
        }
        let addresses = addresses.split(',').filter(|address| !address.is_empty());
        Ok(Self {
            host: host.to_owned(),
            addresses: addresses.map(str::to_owned).collect(),
        })
    }
}

/// Makes the new folder with `ca.pem`, and `HOST.pem` and `HOST.key` for each of `hosts`.
///
/// # Errors
/// One line naming what cannot be.
pub fn make(folder: &Path, hosts: &[Named]) -> Result<(), String> {
    let failed = |error: rcgen::Error| format!("making certificates: {error}");
    let written =
        |name: &str, error: std::io::Error| format!("{}: {error}", folder.join(name).display());
    let key = KeyPair::generate().map_err(failed)?;
    let mut authority = CertificateParams::new(Vec::new()).map_err(failed)?;
    authority.is_ca = IsCa::Ca(BasicConstraints::Constrained(0));
    authority.key_usages = vec![KeyUsagePurpose::KeyCertSign];
    let name = &mut authority.distinguished_name;
    name.push(DnType::CommonName, "hosts of a zeronav stack");
    let certificate = authority.self_signed(&key).map_err(failed)?;
    let issuer = Issuer::new(authority, key);
    DirBuilder::new()
        .mode(0o700)
        .create(folder)
        .map_err(|error| written("", error))?;
    let write = |name: &str, text: &str| {
        let file = OpenOptions::new()
            .write(true)
            .create_new(true)
            .mode(0o600)
            .open(folder.join(name));
        file.and_then(|mut file| file.write_all(text.as_bytes()))
            .map_err(|error| written(name, error))
    };
    write("ca.pem", &certificate.pem())?;
    for Named { host, addresses } in hosts {
        let key = KeyPair::generate().map_err(failed)?;
        let names = [std::slice::from_ref(host), addresses].concat();
        let mut own = CertificateParams::new(names).map_err(failed)?;
        own.distinguished_name
            .push(DnType::CommonName, host.as_str());
        // Either of them may connect or listen.
        own.extended_key_usages = vec![
            ExtendedKeyUsagePurpose::ServerAuth,
            ExtendedKeyUsagePurpose::ClientAuth,
        ];
        let certificate = own.signed_by(&key, &issuer).map_err(failed)?;
        write(&format!("{host}.pem"), &certificate.pem())?;
        write(&format!("{host}.key"), &key.serialize_pem())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::MetadataExt;

    #[test]
    fn every_host_has_its_files_and_nobody_else_reads_them() {
        let folder = std::env::temp_dir().join(format!("zeronav-keys-{}", std::process::id()));
        let hosts =
            ["robot", "base=10.0.0.2,base.local"].map(|text| Named::parse(text).expect(text));
        make(&folder, &hosts).expect("made");
        let mut names: Vec<_> = (std::fs::read_dir(&folder).expect("a folder"))
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .into_string()
                    .expect("text")
            })
            .collect();
        names.sort();
        assert_eq!(
            names,
            ["base.key", "base.pem", "ca.pem", "robot.key", "robot.pem"]
        );
        for name in &names {
            let mode = folder.join(name).metadata().expect("a file").mode();
            assert_eq!(mode & 0o077, 0, "{name}");
        }
        let again = make(&folder, &hosts).expect_err("it is there");
        assert!(again.contains("exists"), "{again}");
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn names_that_would_be_files_elsewhere_are_refused() {
        for text in ["", "=a", "../x", "a/b", "ca", "Base"] {
            assert!(Named::parse(text).is_err(), "{text}");
        }
        let base = Named::parse("base=10.0.0.2,base.local").expect("a host");
        assert_eq!(base.addresses, ["10.0.0.2", "base.local"]);
        assert!(Named::parse("robot").expect("a host").addresses.is_empty());
    }
}
