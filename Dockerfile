# The program alone, for clusters: without recordings for the Rerun viewer.
#
#     docker build -t scanbench .
#
# `.ci/cluster container` builds it, and runs a shard in it.

FROM rust:1.95-slim-bookworm AS build
# git gives the commit that the program is built from; manifests of runs have it.
RUN apt-get update \
    && apt-get install -y --no-install-recommends git \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /source
COPY . .
# Names of functions are more than a quarter of the program. Without them a panic still has its message, file and line.
ENV CARGO_PROFILE_RELEASE_STRIP=symbols CARGO_INCREMENTAL=0
RUN git config --global --add safe.directory /source \
    && cargo build --release --locked --package scanbench --no-default-features

FROM debian:bookworm-slim
COPY --from=build /source/target/release/scanbench /usr/local/bin/scanbench
# Nobody in particular: what a cluster lets it write to is the cluster's choice.
USER 65534:65534
WORKDIR /work
ENTRYPOINT ["scanbench"]
