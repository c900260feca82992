//! Figure 6's curve: the error of a surface that keeps a share of its wavelet coefficients, by wavelet.
//!
//! `kept FILE.boz [OUT.svg]` sorts the coefficients after L2 normalisation, drops the smallest, and prints for every share kept what the
//! dropped ones foretell and what is measured, over the diagonal, in the wavelets' own norm; and draws both.

use bozzetto_core::file::decode;
use bozzetto_core::lod::{domain_distance, keep_largest};
use bozzetto_core::surface::{Form, Surface};
use bozzetto_core::wavelet::Wavelet;
use std::fmt::Write;
use std::path::Path;

/// Shares of the coefficients, in per cent.
const SHARES: [f64; 11] = [0.3, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0, 20.0, 30.0, 50.0, 70.0];
const COLOURS: [&str; 4] = ["#7f7f7f", "#d62728", "#ff9e2c", "#1f77b4"];

/// What keeping a share costs, foretold and measured.
struct Point {
    share: f64,
    foretold: f64,
    measured: f64,
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (file, drawing) = match &arguments[..] {
        [file] => (file, None),
        [file, drawing] => (file, Some(drawing)),
        _ => {
            eprintln!("kept FILE.boz [OUT.svg]; see the top of core/examples/kept.rs");
            std::process::exit(2);
        }
    };
    let bytes = std::fs::read(file).expect("a readable file");
    let surface = decode(&bytes, Path::new(file)).expect("a wavelet file").surface;
    let curves: Vec<(Wavelet, Vec<Point>)> =
        Wavelet::ALL.into_iter().map(|wavelet| (wavelet, curve(&surface, wavelet))).collect();
    for (wavelet, points) in &curves {
        println!("{wavelet}: share kept, error foretold, measured, measured over foretold");
        for Point { share, foretold, measured } in points {
            println!("  {share:>5} %  {foretold:.3e}  {measured:.3e}  {:.3}", measured / foretold);
        }
    }
    if let Some(path) = drawing {
        std::fs::write(path, draw(&curves)).expect("a writable path");
    }
}

fn curve(surface: &Surface, wavelet: Wavelet) -> Vec<Point> {
    let form = Form { wavelet, ..surface.form().clone() };
    let finest = surface.scaling(surface.finest()).to_vec();
    let hierarchy = surface.hierarchy().as_ref().clone();
    let whole = Surface::from_finest(hierarchy, form, finest).expect("small valences");
    let diagonal = whole.to_mesh(whole.finest()).diagonal();
    let at = |share: f64| {
        let kept = keep_largest(&whole, share / 100.0);
        let measured = domain_distance(&whole, &kept.surface) / diagonal;
        Point { share, foretold: kept.predicted / diagonal, measured }
    };
    SHARES.into_iter().map(at).collect()
}

/// Both axes logarithmic; lines are measured, rings foretold.
fn draw(curves: &[(Wavelet, Vec<Point>)]) -> String {
    let (width, height, left, bottom) = (640.0, 400.0, 70.0, 360.0);
    let errors = || curves.iter().flat_map(|(_, points)| points).flat_map(|p| [p.foretold, p.measured]);
    let low = errors().fold(f64::INFINITY, f64::min).log10().floor();
    let high = errors().fold(0.0, f64::max).log10().ceil();
    let x = |share: f64| left + (width - left - 20.0) * (share / 0.2).log10() / 500f64.log10();
    let y = |error: f64| bottom - (bottom - 20.0) * (error.log10() - low) / (high - low);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    // Writing to a string cannot fail.
    let mut line = |text: String| {
        let _ = writeln!(svg, "{text}");
    };
    for decade in low as i32..=high as i32 {
        let at = y(10f64.powi(decade));
        line(format!("<path d=\"M{left} {at:.1}H{}\" stroke=\"#ddd\"/>", width - 20.0));
        line(format!(
            "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">1e{decade}</text>",
            left - 8.0,
            at + 4.0
        ));
    }
    for share in [0.3, 1.0, 3.0, 12.0, 30.0, 100.0] {
        let at = x(share);
        line(format!("<path d=\"M{at:.1} 20V{bottom}\" stroke=\"#ddd\"/>"));
        line(format!("<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{share} %</text>", bottom + 18.0));
    }
    let middle = (left + width) / 2.0;
    line(format!(
        "<text x=\"{middle}\" y=\"{}\" text-anchor=\"middle\">coefficients kept</text>",
        height - 6.0
    ));
    line("<text x=\"8\" y=\"14\">error over the diagonal: lines measured, rings foretold</text>".to_owned());
    for (at, ((wavelet, points), colour)) in curves.iter().zip(COLOURS).enumerate() {
        let corner = |p: &Point| format!("{:.1},{:.1}", x(p.share), y(p.measured));
        let corners: Vec<String> = points.iter().map(corner).collect();
        line(format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\"/>",
            corners.join(" ")
        ));
        for p in points {
            let (x, y) = (x(p.share), y(p.foretold));
            line(format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"none\" stroke=\"{colour}\"/>"));
        }
        let row = 250.0 + 20.0 * at as f64;
        line(format!("<path d=\"M{} {row}h24\" stroke=\"{colour}\" stroke-width=\"2\"/>", left + 20.0));
        line(format!("<text x=\"{}\" y=\"{}\">{wavelet}</text>", left + 52.0, row + 4.0));
    }
    svg + "</svg>\n"
}
