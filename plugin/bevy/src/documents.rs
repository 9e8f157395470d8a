//! Rust code of the workspace's documents, compiled as documentation tests.

#[doc = include_str!("../../../README.md")]
struct Readme;

#[doc = include_str!("../../../docs/getting_started.md")]
struct GettingStarted;

#[doc = include_str!("../../../docs/detail.md")]
struct Detail;

#[doc = include_str!("../../../docs/air.md")]
struct Air;

#[doc = include_str!("../../../docs/queries.md")]
struct Queries;

#[doc = include_str!("../../../docs/heat.md")]
struct Heat;

#[doc = include_str!("../../../docs/link.md")]
struct LiveLink;

#[doc = include_str!("../README.md")]
struct PluginReadme;

#[doc = include_str!("../../../runtime/sheetwork/README.md")]
struct LibraryReadme;
