//! The report as a page.

use super::Report;
use super::charts::{colour_bar, histogram};
use super::html::{Text, pairs};
use super::pictures::Pictures;
use super::quality::WELL_SHAPED;
use crate::figures::{counted, grouped, length, percent, significant, tolerance};
use crate::opening::Stage;
use bozzetto_core::conversion::Remesh;
use bozzetto_core::mesh::OneWay;
use bozzetto_core::wavelet::Wavelet;

/// The look; light and dark.
const STYLE: &str = include_str!("page.css");

/// The whole page.
pub(super) fn page(report: &Report<'_>) -> String {
    let name = report.name();
    let sections = [
        report.head(),
        report.pictures(),
        section("Distance between mesh and surface", &report.distances()),
        columns(section("Triangles", &report.triangles()), section("Base mesh", &report.valences())),
        columns(section("Shape", &report.shape()), section("Repairs", &report.repairs())),
        columns(section("Settings", &report.settings()), section("Time", &report.times())),
        section("Files", &report.files()),
    ];
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; \
         style-src 'unsafe-inline'\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>Import of {}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{}</main>\n</body>\n</html>\n",
        Text(name),
        sections.concat()
    )
}

fn section(title: &str, content: &str) -> String {
    format!("<section>\n<h2>{title}</h2>\n{content}</section>\n")
}

/// Two sections side by side where there is room.
fn columns(left: String, right: String) -> String {
    format!("<div class=\"columns\">\n{left}{right}</div>\n")
}

impl Report<'_> {
    /// What the mesh is called.
    fn name(&self) -> &str {
        self.source.metadata.source.as_deref().unwrap_or(&self.source.name)
    }

    fn unit(&self) -> &str {
        &self.imported.model.surface.form().placement.unit
    }

    fn head(&self) -> String {
        let hierarchy = self.imported.model.surface.hierarchy();
        let base = hierarchy.base().faces().len();
        let what = if self.imported.model.source.is_some() {
            "The mesh has subdivision connectivity; its vertices were kept"
        } else if self.imported.kept {
            "The mesh was taken as its own base mesh"
        } else {
            "The mesh was converted"
        };
        let levels = counted(hierarchy.finest().0.into(), "level", "levels");
        let [rms, max] = self.imported.distance;
        let verdict = self.options.conversion.tolerance.map_or(String::new(), |demanded| {
            let class = if max <= demanded { "met" } else { "missed" };
            let sentence = tolerance(max, demanded);
            format!("<p>Tolerance <span class=\"{class}\">{}</span>.</p>\n", Text(&sentence))
        });
        format!(
            "<header>\n<h1>Import of {}</h1>\n<p class=\"lead\">{what}: {levels} over {} base faces, {} vertices in \
             all. The surfaces lie {} (rms) and at most {} of the diagonal apart.</p>\n{verdict}</header>\n",
            Text(self.name()),
            grouped(base as u64),
            grouped(u64::from(hierarchy.layout(hierarchy.finest()).len())),
            percent(rms),
            percent(max),
        )
    }

    fn pictures(&self) -> String {
        let drawn = match &self.pictures {
            Pictures::Drawn(drawn) => drawn,
            Pictures::None(why) => {
                return format!(
                    "<p class=\"note\">There are no pictures: {}. All figures below are complete.</p>\n",
                    Text(why)
                );
            }
        };
        let figure = |address: &str, title: &str, says: &str, more: &str| {
            format!(
                "<figure>\n<img alt=\"{title}\" src=\"{address}\">\n<figcaption><b>{title}.</b> {says}</figcaption>\n\
                 {more}</figure>\n"
            )
        };
        let mesh = &self.source.mesh;
        let hierarchy = self.imported.model.surface.hierarchy();
        let read = format!(
            "{} vertices, {} faces.",
            grouped(mesh.positions.len() as u64),
            grouped(mesh.faces.len() as u64)
        );
        let made = format!(
            "{} vertices, {} faces.",
            grouped(u64::from(hierarchy.layout(hierarchy.finest()).len())),
            grouped(hierarchy.face_count(hierarchy.finest()))
        );
        let base =
            format!("{} faces: level 0, with its edges.", grouped(hierarchy.base().faces().len() as u64));
        let bar = colour_bar(&drawn.scale, self.comparison.diagonal, self.unit());
        format!(
            "<div class=\"pictures\">\n{}{}{}{}</div>\n",
            figure(&drawn.mesh, "Before: the mesh", &read, ""),
            figure(&drawn.surface, "After: the surface", &made, ""),
            figure(&drawn.base, "Base mesh", &base, ""),
            figure(&drawn.error, "Error", "Distance of the surface's vertices from the mesh.", &bar),
        )
    }

    fn distances(&self) -> String {
        let diagonal = self.comparison.diagonal;
        let row = |name: &str, way: OneWay| {
            let cells: String = [way.mean, way.rms, way.max]
                .iter()
                .map(|&d| {
                    format!("<td>{}</td><td>{}</td>", percent(d), Text(&length(d * diagonal, self.unit())))
                })
                .collect();
            format!("<tr><th scope=\"row\">{name}</th>{cells}</tr>\n")
        };
        let psnr = self.comparison.psnr.map_or("The surfaces coincide.".to_owned(), |psnr| {
            format!("Peak signal-to-noise ratio {psnr:.1} dB.")
        });
        format!(
            "<table class=\"figures\">\n<thead><tr><th></th><th scope=\"col\" colspan=\"2\">mean</th>\
             <th scope=\"col\" colspan=\"2\">rms</th><th scope=\"col\" colspan=\"2\">maximum</th></tr></thead>\n\
             <tbody>\n{}{}</tbody>\n</table>\n<p class=\"faint\">In percent of the mesh's bounding-box diagonal, {}, \
             and in {}. {psnr}</p>\n",
            row("mesh to surface", self.comparison.a_to_b),
            row("surface to mesh", self.comparison.b_to_a),
            Text(&length(diagonal, self.unit())),
            if self.unit().is_empty() { "model units".to_owned() } else { Text(self.unit()).to_string() },
        )
    }

    fn shape(&self) -> String {
        let base = self.imported.model.surface.hierarchy().base();
        let sharp = base.sharp_edges().len() as u32;
        let mut rows = vec![
            ("Components", grouped(u64::from(base.components()))),
            ("Genus", grouped(u64::from(base.genus()))),
            ("Boundary loops", grouped(u64::from(base.boundary_loops()))),
        ];
        if sharp > 0 {
            rows.push(("Sharp edges", counted(sharp, "base edge", "base edges")));
        }
        pairs(rows)
    }

    fn triangles(&self) -> String {
        let [finest, base] = &self.angles;
        let share = |share: f64| format!("{:.1}\u{202f}%", share * 100.0);
        format!(
            "<p>The smallest angle is above {WELL_SHAPED}° in {} of the surface's triangles (least {:.1}°) and in {} of \
             the base mesh's (least {:.1}°).</p>\n{}<p class=\"faint\">Triangles of the surface by their smallest \
             angle.</p>\n",
            share(finest.well_shaped),
            finest.least,
            share(base.well_shaped),
            base.least,
            histogram(finest),
        )
    }

    fn valences(&self) -> String {
        let rows: String = self
            .valences
            .rows
            .iter()
            .map(|&(valence, inside, boundary)| {
                let (inside, boundary) = (grouped(inside as u64), grouped(boundary as u64));
                format!("<tr><th scope=\"row\">{valence}</th><td>{inside}</td><td>{boundary}</td></tr>\n")
            })
            .collect();
        format!(
            "<p>{:.1}\u{202f}% of the base vertices are regular (6 faces inside, 3 on the boundary).</p>\n\
             <table class=\"figures\">\n<thead><tr><th scope=\"col\">faces at a vertex</th>\
             <th scope=\"col\">inside</th><th scope=\"col\">on the boundary</th></tr></thead>\n<tbody>\n{rows}</tbody>\n\
             </table>\n",
            self.valences.regular * 100.0,
        )
    }

    fn repairs(&self) -> String {
        if self.imported.cleaned.is_empty() {
            return "<p>Nothing had to be repaired.</p>\n".to_owned();
        }
        let items: String =
            self.imported.cleaned.iter().map(|sentence| format!("<li>{}</li>\n", Text(sentence))).collect();
        format!("<ul>\n{items}</ul>\n")
    }

    fn settings(&self) -> String {
        let conversion = &self.options.conversion;
        let form = &self.options.form;
        let automatic = || "automatic".to_owned();
        pairs([
            (
                "Remesh",
                match conversion.remesh {
                    Remesh::Auto => "where there is no subdivision connectivity",
                    Remesh::Always => "always",
                    Remesh::Never => "never",
                }
                .to_owned(),
            ),
            ("Levels", conversion.levels.map_or_else(automatic, |levels| levels.to_string())),
            ("Base faces", conversion.base_faces.map_or_else(automatic, |n| format!("at most {n}"))),
            ("Sharp angle", conversion.sharp_angle.map_or_else(automatic, |angle| format!("{angle}°"))),
            ("Symmetry", conversion.symmetric.map_or("none".to_owned(), |axis| format!("along {axis}"))),
            ("Tolerance", conversion.tolerance.map_or("none".to_owned(), percent)),
            (
                "Wavelet",
                match form.wavelet {
                    Wavelet::Lazy => "lazy".to_owned(),
                    Wavelet::Disc(k) => format!("{k}-disc"),
                },
            ),
            ("Scheme", form.scheme.to_string()),
            ("Precision", format!("{} bits", form.precision)),
            ("Up axis", form.up.to_string()),
            ("Unit", if form.unit.is_empty() { "unknown".to_owned() } else { form.unit.clone() }),
        ])
    }

    fn times(&self) -> String {
        let total: f64 = self.seconds.iter().map(|(_, seconds)| seconds).sum();
        let longest = self.seconds.iter().map(|(_, seconds)| *seconds).fold(1e-9, f64::max);
        let row = |&(stage, seconds): &(Stage, f64)| {
            let width = seconds / longest * 120.0;
            format!(
                "<tr><th scope=\"row\">{}</th><td>{}\u{202f}s</td><td><span class=\"time\" \
                 style=\"width: {width:.0}px\"></span></td></tr>\n",
                stage.name(),
                significant(seconds)
            )
        };
        let rows: String = self.seconds.iter().map(row).collect();
        format!(
            "<table class=\"pairs\">\n{rows}<tr><th scope=\"row\">Together</th><td>{}\u{202f}s</td><td></td></tr>\n\
             </table>\n",
            significant(total)
        )
    }

    fn files(&self) -> String {
        let hash = self.source.metadata.source_sha256.as_deref().unwrap_or("unknown");
        let row = |name: &str, value: &str| {
            format!("<tr><th scope=\"row\">{name}</th><td><code>{}</code></td></tr>\n", Text(value))
        };
        format!(
            "<table class=\"pairs\">\n{}{}{}{}</table>\n<p class=\"faint\">Made by Bozzetto {}.</p>\n",
            row("Mesh", self.name()),
            row("Its SHA-256", hash),
            row("Wavelet file", &self.output),
            row("Surface hash", &self.imported.model.surface.hash().to_string()),
            env!("CARGO_PKG_VERSION"),
        )
    }
}
