//! Access to the objects below an address.

use std::sync::Arc;
use std::time::{Duration, SystemTime};

use futures_util::{StreamExt as _, TryStreamExt as _};
use object_store::aws::AmazonS3Builder;
use object_store::gcp::GoogleCloudStorageBuilder;
use object_store::http::HttpBuilder;
use object_store::path::Path;
use object_store::{
    BackoffConfig, ClientOptions, GetOptions, GetRange, ObjectMeta, ObjectStore, ObjectStoreExt as _,
    RetryConfig,
};

use crate::RemoteError;
use crate::address::{Address, Scheme};
use crate::patience::Progress;
use crate::sums::{SUMS_FILE, Sums, parse_sums};

/// A server that takes longer to connect is not there.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);
/// A server that sends nothing for longer is gone.
const READ_TIMEOUT: Duration = Duration::from_mins(1);
/// Requests that fail for a moment are repeated this often, within this time.
const N_RETRIES: usize = 5;
const RETRY_TIMEOUT: Duration = Duration::from_secs(90);
/// A file of checksums is larger than this by mistake only.
const LONGEST_SUMS_BYTES: u64 = 256 << 20;
/// This many requests are made to a server at a time.
const N_AT_A_TIME: usize = 16;

/// Variables of the environment with credentials, or with the wish to sign nothing.
const S3_CREDENTIALS: [&str; 5] = [
    "AWS_ACCESS_KEY_ID",
    "AWS_SKIP_SIGNATURE",
    "AWS_WEB_IDENTITY_TOKEN_FILE",
    "AWS_CONTAINER_CREDENTIALS_RELATIVE_URI",
    "AWS_CONTAINER_CREDENTIALS_FULL_URI",
];
const GS_CREDENTIALS: [&str; 5] = [
    "GOOGLE_APPLICATION_CREDENTIALS",
    "GOOGLE_SERVICE_ACCOUNT",
    "GOOGLE_SERVICE_ACCOUNT_PATH",
    "GOOGLE_SERVICE_ACCOUNT_KEY",
    "GOOGLE_SKIP_SIGNATURE",
];

/// Access to a bucket beyond the settings of the environment.
#[derive(Debug, Clone, Default)]
pub struct Access {
    /// The bucket is open to everybody: nothing is signed.
    pub is_public: bool,
    /// The region of the bucket.
    pub region: Option<String>,
}

/// An object, and the file that it becomes.
#[derive(Debug, Clone, PartialEq)]
pub struct RemoteFile {
    /// The path of the file below the folder it is fetched into, with `/` between folders.
    pub name: String,
    /// Size in bytes.
    pub n_bytes: u64,
    /// When it was written, as far as the server says.
    pub modified: Option<SystemTime>,
    /// SHA-256 in lower-case hexadecimal, as far as the server's `SHA256SUMS` says.
    pub sha256: Option<String>,
    pub(crate) location: Path,
    pub(crate) e_tag: Option<String>,
}

impl RemoteFile {
    /// Whether it is the object that `address` names.
    pub fn is_at(&self, address: &Address) -> bool {
        self.location == *address.path()
    }
}

/// A bucket or a server.
pub struct Store {
    objects: Arc<dyn ObjectStore>,
    address: Address,
    pub(crate) progress: Progress,
}

impl Store {
    /// Opens `address` with the credentials of the environment: `AWS_…` and `GOOGLE_…`, as their own tools have them.
    ///
    /// # Errors
    ///
    /// [`RemoteError::Refused`] if there are none; [`RemoteError::Address`] if the environment contradicts itself.
    pub fn open(address: &Address, access: &Access) -> Result<Self, RemoteError> {
        // An earlier caller has installed the same provider: there is only one.
        let _ = rustls::crypto::ring::default_provider().install_default();
        let names = match address.scheme() {
            Scheme::S3 => &S3_CREDENTIALS[..],
            Scheme::Gs => &GS_CREDENTIALS,
            Scheme::Http => &[],
        };
        // Without credentials, it would ask metadata servers of the cloud's own machines, which do not exist elsewhere.
        if !access.is_public && !names.is_empty() && names.iter().all(|it| std::env::var_os(it).is_none()) {
            return Err(RemoteError::without_credentials(&address.shown()));
        }
        let objects = open_objects(address, access)
            .map_err(|error| RemoteError::Address { address: address.shown(), problem: error.to_string() })?;
        Ok(Self { objects, address: address.clone(), progress: Progress::default() })
    }

    /// The address that it was opened with.
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// The address of an object, as it is shown.
    pub(crate) fn shown(&self, location: &Path) -> String {
        self.address.shown_at(location)
    }

    /// Gets an object from its byte `from` on, if it is still the listed one.
    pub(crate) async fn get_from(
        &self,
        file: &RemoteFile,
        from: u64,
    ) -> Result<object_store::GetResult, object_store::Error> {
        let range = (from > 0).then_some(GetRange::Offset(from));
        // Weak tags never match.
        let if_match = file.e_tag.clone().filter(|it| !it.starts_with("W/"));
        self.objects.get_opts(&file.location, GetOptions { range, if_match, ..GetOptions::default() }).await
    }

    /// All files at its address, sorted by name: those below it, or the one that it names.
    pub(crate) async fn all(&self) -> Result<Vec<RemoteFile>, RemoteError> {
        let address = &self.address;
        if address.scheme() == Scheme::Http && !address.looks_like_a_folder() {
            return Ok(vec![self.head(address.path(), "").await?]);
        }
        let files = self.below(address.path(), "").await?;
        if !files.is_empty() {
            return Ok(files);
        }
        match self.head(address.path(), "").await {
            Ok(file) if !file.name.is_empty() => Ok(vec![file]),
            Ok(_) | Err(RemoteError::Nothing { .. }) => {
                Err(RemoteError::Nothing { url: address.shown(), remedy: self.how_to_list() })
            }
            Err(error) => Err(error),
        }
    }

    fn how_to_list(&self) -> &'static str {
        match self.address.scheme() {
            Scheme::Http => {
                "; a server says what a folder has by WebDAV, or by a file SHA256SUMS in it, which \
                 sha256sum $(find * -type f) > SHA256SUMS makes"
            }
            Scheme::S3 | Scheme::Gs => "; an address names a file, or the folder of a data set",
        }
    }

    /// The names of the folders at its address, sorted.
    pub(crate) async fn folders(&self) -> Result<Vec<String>, RemoteError> {
        let path = self.address.path();
        let listed = self.objects.list_with_delimiter(Some(path)).await;
        let listed = listed.map_err(|error| RemoteError::of_store(&self.address.shown(), &error))?;
        let mut names: Vec<String> =
            listed.common_prefixes.iter().filter_map(|it| it.filename().map(str::to_owned)).collect();
        names.sort();
        names.dedup();
        Ok(names)
    }

    /// The files at `names` below its address, sorted by name; a name that ends in `/` stands for all files below that
    /// folder.
    pub(crate) async fn named(&self, names: &[String]) -> Result<Vec<RemoteFile>, RemoteError> {
        let of_name = |name: &String| {
            let name = name.clone();
            async move {
                let (is_folder, name) = (name.ends_with('/'), name.trim_end_matches('/').to_owned());
                let path = self.path_at(&name)?;
                let files = if is_folder {
                    self.below(&path, &name).await?
                } else {
                    vec![RemoteFile { name, ..self.head(&path, "").await? }]
                };
                if files.is_empty() {
                    return Err(RemoteError::Nothing { url: self.shown(&path), remedy: "" });
                }
                Ok(files)
            }
        };
        let found: Vec<Vec<RemoteFile>> =
            futures_util::stream::iter(names.iter().map(of_name)).buffered(N_AT_A_TIME).try_collect().await?;
        let mut files = found.concat();
        files.sort_by(|a, b| a.name.cmp(&b.name));
        files.dedup_by(|a, b| a.name == b.name);
        Ok(files)
    }

    /// The path of `name` below its address.
    fn path_at(&self, name: &str) -> Result<Path, RemoteError> {
        let base = self.address.path();
        let whole = if base.as_ref().is_empty() { name.to_owned() } else { format!("{base}/{name}") };
        Path::parse(&whole)
            .map_err(|error| RemoteError::Address { address: whole, problem: error.to_string() })
    }

    /// The files below the folder `path`, which are called `NAME/…`.
    async fn below(&self, path: &Path, name: &str) -> Result<Vec<RemoteFile>, RemoteError> {
        let sums = self.sums_in(path).await?;
        if self.address.scheme() == Scheme::Http
            && let Some(sums) = &sums
        {
            return self.of_sums(path, name, sums).await;
        }
        let listed: Vec<ObjectMeta> = match self.listed(path).await {
            Ok(listed) => listed,
            // A server without WebDAV.
            Err(_) if self.address.scheme() == Scheme::Http => Vec::new(),
            Err(error) => return Err(RemoteError::of_store(&self.shown(path), &error)),
        };
        let mut files: Vec<RemoteFile> = listed
            .into_iter()
            .filter_map(|meta| {
                let below: Vec<String> =
                    meta.location.prefix_match(path)?.map(|it| it.as_ref().to_owned()).collect();
                let below = below.join("/");
                let sha256 = sums.as_ref().and_then(|it| it.get(&below)).cloned();
                (!below.is_empty()).then(|| RemoteFile { sha256, ..remote_file(joined(name, &below), meta) })
            })
            .collect();
        files.sort_by(|a, b| a.name.cmp(&b.name));
        // Some tools leave an empty object for a folder.
        let is_folder: Vec<bool> = (0..files.len())
            .map(|it| {
                let begin = format!("{}/", files[it].name);
                files[it].n_bytes == 0 && files[it + 1..].iter().any(|other| other.name.starts_with(&begin))
            })
            .collect();
        let mut is_folder = is_folder.into_iter();
        files.retain(|_| is_folder.next() != Some(true));
        Ok(files)
    }

    async fn listed(&self, path: &Path) -> Result<Vec<ObjectMeta>, object_store::Error> {
        self.objects.list(Some(path)).inspect_ok(|_| self.progress.answer()).try_collect().await
    }

    /// The files that the checksums of the folder `path` name, and the file of checksums itself.
    async fn of_sums(&self, path: &Path, name: &str, sums: &Sums) -> Result<Vec<RemoteFile>, RemoteError> {
        let names = sums.keys().map(String::as_str).chain([SUMS_FILE]);
        let of_name = |below: &str| {
            let below = below.to_owned();
            async move {
                let location = Path::parse(format!("{path}/{below}").trim_start_matches('/'));
                let location = location.map_err(|error| RemoteError::Address {
                    address: below.clone(),
                    problem: error.to_string(),
                })?;
                let file = self.head(&location, "; SHA256SUMS beside it names it").await?;
                Ok(RemoteFile { sha256: sums.get(&below).cloned(), name: joined(name, &below), ..file })
            }
        };
        let mut files: Vec<RemoteFile> =
            futures_util::stream::iter(names.map(of_name)).buffered(N_AT_A_TIME).try_collect().await?;
        files.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(files)
    }

    /// The checksums of the folder `path`, if it has a file of them.
    async fn sums_in(&self, path: &Path) -> Result<Option<Sums>, RemoteError> {
        let path = path.clone().join(SUMS_FILE);
        let url = self.shown(&path);
        let result = match self.objects.get(&path).await {
            Ok(result) => result,
            // Buckets that may not be listed also refuse objects that are not there.
            Err(
                object_store::Error::NotFound { .. }
                | object_store::Error::PermissionDenied { .. }
                | object_store::Error::Unauthenticated { .. },
            ) => return Ok(None),
            Err(error) => return Err(RemoteError::of_store(&url, &error)),
        };
        if result.meta.size > LONGEST_SUMS_BYTES {
            let reason = "it is too large for a list of checksums".to_owned();
            return Err(RemoteError::Unreachable { url, reason });
        }
        let came = result.into_stream().inspect_ok(|it| self.progress.bytes(it.len() as u64));
        let pieces: Vec<_> = came.try_collect().await.map_err(|error| RemoteError::of_store(&url, &error))?;
        let bytes = pieces.concat();
        self.progress.answer();
        parse_sums(&url, &String::from_utf8_lossy(&bytes)).map(Some)
    }

    /// The object at `path`; if there is none, the error ends in `remedy`.
    async fn head(&self, path: &Path, remedy: &'static str) -> Result<RemoteFile, RemoteError> {
        let name = path.filename().unwrap_or_default().to_owned();
        let error = match self.objects.head(path).await {
            Ok(meta) => {
                self.progress.answer();
                return Ok(remote_file(name, meta));
            }
            Err(error) => error,
        };
        // Links may be signed for reading alone: the answer to a request for the first byte tells the size, too.
        if self.address.scheme() == Scheme::Http && !matches!(error, object_store::Error::NotFound { .. }) {
            let first = GetOptions { range: Some(GetRange::Bounded(0..1)), ..GetOptions::default() };
            if let Ok(result) = self.objects.get_opts(path, first).await {
                return Ok(remote_file(name, result.meta));
            }
        }
        match RemoteError::of_store(&self.shown(path), &error) {
            RemoteError::Nothing { url, .. } => Err(RemoteError::Nothing { url, remedy }),
            error => Err(error),
        }
    }
}

fn joined(name: &str, below: &str) -> String {
    if name.is_empty() { below.to_owned() } else { format!("{name}/{below}") }
}

fn remote_file(name: String, meta: ObjectMeta) -> RemoteFile {
    let modified = SystemTime::from(meta.last_modified);
    // A server that states no time gives the beginning of the epoch.
    let modified = (modified > SystemTime::UNIX_EPOCH).then_some(modified);
    let e_tag = meta.e_tag.filter(|it| !it.is_empty());
    RemoteFile { name, n_bytes: meta.size, modified, sha256: None, location: meta.location, e_tag }
}

fn open_objects(address: &Address, access: &Access) -> Result<Arc<dyn ObjectStore>, object_store::Error> {
    let options = |is_plain: bool| {
        ClientOptions::new()
            // Large files take as long as they take.
            .with_timeout_disabled()
            .with_connect_timeout(CONNECT_TIMEOUT)
            .with_read_timeout(READ_TIMEOUT)
            .with_allow_http(is_plain)
    };
    let backoff = BackoffConfig { max_backoff: Duration::from_secs(5), ..BackoffConfig::default() };
    let retry = RetryConfig { backoff, max_retries: N_RETRIES, retry_timeout: RETRY_TIMEOUT };
    Ok(match address.scheme() {
        Scheme::S3 => {
            let mut builder = AmazonS3Builder::from_env()
                .with_bucket_name(address.host())
                .with_client_options(options(is_plain_by("AWS_ALLOW_HTTP", "AWS_ENDPOINT")))
                .with_retry(retry);
            if let Some(region) = &access.region {
                builder = builder.with_region(region);
            }
            if access.is_public {
                builder = builder.with_skip_signature(true);
            }
            Arc::new(builder.build()?)
        }
        Scheme::Gs => {
            let mut builder = GoogleCloudStorageBuilder::from_env()
                .with_bucket_name(address.host())
                .with_client_options(options(is_plain_by("GOOGLE_ALLOW_HTTP", "GOOGLE_BASE_URL")))
                .with_retry(retry);
            if access.is_public {
                builder = builder.with_skip_signature(true);
            }
            Arc::new(builder.build()?)
        }
        Scheme::Http => {
            let builder = HttpBuilder::new().with_url(address.server());
            Arc::new(builder.with_client_options(options(address.is_plain())).with_retry(retry).build()?)
        }
    })
}

/// Whether the environment names a server without encryption, as those on one's own machine are: by a variable of its own,
/// or by an address in a variable whose name begins with `endpoint`.
fn is_plain_by(allowed: &str, endpoint: &str) -> bool {
    let is_allowed = std::env::var(allowed).is_ok_and(|it| it.eq_ignore_ascii_case("true"));
    let mut texts = std::env::vars_os().filter_map(|(name, value)| Some((name.into_string().ok()?, value)));
    is_allowed
        || texts
            .any(|(name, value)| name.starts_with(endpoint) && value.to_string_lossy().starts_with("http://"))
}
