//! Addresses of objects, such as `s3://bucket/drives/street`.

use std::path::PathBuf;

use object_store::path::Path;
use url::Url;

use crate::RemoteError;

/// Way to reach objects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scheme {
    /// `s3://`: buckets of Amazon S3, and of servers that speak its protocol.
    S3,
    /// `gs://`: buckets of Google Cloud Storage.
    Gs,
    /// `https://` and `http://`: servers.
    Http,
}

/// Where objects lie: a bucket or a server, and a path in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    // Invariant: has a host, no user, no password and no fragment.
    url: Url,
    path: Path,
    scheme: Scheme,
}

impl Address {
    /// Reads an address without a query: those are secret, and addresses of data sets are written into manifests.
    ///
    /// # Errors
    ///
    /// [`RemoteError::Address`].
    pub fn parse(text: &str) -> Result<Self, RemoteError> {
        let address = Self::parse_link(text)?;
        if address.url.query().is_some() {
            let problem =
                "it has a query (?…); fetch a signed link with `scanbench data get NAME --link URL`";
            return Err(RemoteError::Address { address: address.shown(), problem: problem.to_owned() });
        }
        Ok(address)
    }

    /// Reads an address that may have a query, as signed links have.
    ///
    /// # Errors
    ///
    /// [`RemoteError::Address`].
    pub fn parse_link(text: &str) -> Result<Self, RemoteError> {
        let refused = |problem: &str| RemoteError::Address {
            address: text.split('?').next().unwrap_or_default().to_owned(),
            problem: problem.to_owned(),
        };
        let url = Url::parse(text).map_err(|error| refused(&error.to_string()))?;
        let scheme = match url.scheme() {
            "s3" => Scheme::S3,
            "gs" => Scheme::Gs,
            "https" | "http" => Scheme::Http,
            other => return Err(refused(&format!("{other} is none of s3, gs, https and http"))),
        };
        if url.host_str().is_none_or(str::is_empty) {
            return Err(refused("it names no bucket or server"));
        }
        if !url.username().is_empty() || url.password().is_some() {
            return Err(refused("it has a name or a password in it, which the environment is for"));
        }
        if url.fragment().is_some() || (scheme != Scheme::Http && url.query().is_some()) {
            return Err(refused("write # and ? as %23 and %3F"));
        }
        let path = Path::from_url_path(url.path()).map_err(|error| refused(&error.to_string()))?;
        Ok(Self { url, path, scheme })
    }

    /// Scheme of the address.
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// The bucket, or the name of the server.
    pub fn host(&self) -> &str {
        self.url.host_str().unwrap_or_default()
    }

    /// The path in the bucket or on the server.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// URL of the server without a path, with the query of the link if it has one.
    pub(crate) fn server(&self) -> Url {
        let mut url = self.url.clone();
        url.set_path("");
        url
    }

    /// Whether it is reached without encryption.
    pub fn is_plain(&self) -> bool {
        self.url.scheme() == "http"
    }

    /// Whether it is meant as a folder, as far as its form says: servers have folders that end in `/`, or have no ending.
    pub fn looks_like_a_folder(&self) -> bool {
        self.url.path().ends_with('/') || self.path.extension().is_none()
    }

    /// As it is shown: without its query.
    pub fn shown(&self) -> String {
        let mut url = self.url.clone();
        url.set_query(None);
        url.to_string()
    }

    /// The address of the object at `path` of the same bucket or server, as it is shown.
    pub fn shown_at(&self, path: &Path) -> String {
        format!("{}{path}", self.root())
    }

    fn root(&self) -> String {
        let port = self.url.port().map_or_else(String::new, |it| format!(":{it}"));
        format!("{}://{}{port}/", self.url.scheme(), self.host())
    }

    /// Where below a cache its objects go: `s3/bucket/drives/street`.
    pub fn cache_folder(&self) -> PathBuf {
        let server = self.root();
        let server = server.trim_end_matches('/').replacen("://", "/", 1).replace(':', "_");
        let mut folder = PathBuf::from(server);
        folder.extend(self.path.parts().map(|it| it.as_ref().to_owned()));
        folder
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(text: &str, expected: Result<(Scheme, &str, &str, &str), &str>) {
        match (Address::parse(text), expected) {
            (Ok(found), Ok((scheme, host, path, cache))) => {
                assert_eq!((found.scheme(), found.host(), found.path().as_ref()), (scheme, host, path));
                assert_eq!(found.cache_folder(), PathBuf::from(cache));
            }
            (Err(error), Err(part)) => assert!(error.to_string().contains(part), "{error}"),
            (found, expected) => panic!("{found:?}, expected {expected:?}"),
        }
    }

    #[test]
    fn addresses_have_a_bucket_and_a_path() {
        check("s3://bucket/a/b", Ok((Scheme::S3, "bucket", "a/b", "s3/bucket/a/b")));
        check("s3://bucket", Ok((Scheme::S3, "bucket", "", "s3/bucket")));
        check("gs://bucket/a%20b/", Ok((Scheme::Gs, "bucket", "a b", "gs/bucket/a b")));
        check("http://127.0.0.1:80/a/", Ok((Scheme::Http, "127.0.0.1", "a", "http/127.0.0.1/a")));
        check("http://127.0.0.1:8080/a/", Ok((Scheme::Http, "127.0.0.1", "a", "http/127.0.0.1_8080/a")));
    }

    #[test]
    fn what_is_no_address_is_refused_without_its_query() {
        check("ftp://host/a", Err("ftp is none of s3, gs, https and http"));
        check("s3:///a", Err("names no bucket"));
        check("https://me:secret@host/a", Err("which the environment is for"));
        check("s3://bucket/a#b", Err("%23"));
        check("s3://bucket/a//b", Err("Path"));
        let error = Address::parse("https://host/a.zip?Signature=secret").unwrap_err().to_string();
        assert!(error.contains("--link") && !error.contains("secret"), "{error}");
        let link = Address::parse_link("https://host/a.zip?Signature=secret").unwrap();
        assert_eq!(link.shown(), "https://host/a.zip");
    }

    #[test]
    fn no_path_leaves_the_cache() {
        for text in [
            "s3://bucket/../../a",
            "s3://bucket/%2e%2e/a",
            "s3://bucket/..%2f..%2fa",
            "http://host/a/..%2f..%2fb",
        ] {
            if let Ok(address) = Address::parse(text) {
                let folder = address.cache_folder();
                assert!(
                    folder.components().all(|it| matches!(it, std::path::Component::Normal(_))),
                    "{folder:?}"
                );
            }
        }
    }
}
