#include "engine/report/style.h"

namespace voidpath::report {

std::string_view style() {
  return R"(
:root {
  color-scheme: light dark;
  --page: #f4f6f8; --card: #ffffff; --ink: #17212b; --soft: #5a6775; --line: #d9e0e7; --faint: #eef2f5;
  --chosen: #0b6fbf; --delivered: #8b95a1; --good: #18794e; --bad: #b4451f; --support: #f59f00; --plate: #e3e9ee;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #11161c; --card: #1a212a; --ink: #e8edf2; --soft: #9aa7b4; --line: #313c48; --faint: #222b35;
    --chosen: #4dabf7; --delivered: #8792a0; --good: #51cf8a; --bad: #ff8f6b; --support: #ffb52e; --plate: #262f39;
  }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); font: 16px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
main { max-width: 1120px; margin: 0 auto; padding: 28px 20px 48px; }
h1 { font-size: 15px; font-weight: 600; color: var(--soft); margin: 0 0 6px; overflow-wrap: anywhere; }
.verdict { font-size: clamp(22px, 3.4vw, 32px); line-height: 1.25; font-weight: 700; margin: 0 0 6px; text-wrap: balance; }
.because { color: var(--soft); margin: 0 0 22px; max-width: 100ch; }
h2 { font-size: 19px; margin: 0 0 4px; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 12px; padding: 20px; margin: 0 0 18px; }
section p.lead { margin: 0 0 14px; color: var(--soft); max-width: 100ch; font-size: 15px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(158px, 1fr)); gap: 12px; margin: 0 0 18px; }
.tile { background: var(--card); border: 1px solid var(--line); border-radius: 12px; padding: 12px 14px; }
.tile .what { font-size: 13px; color: var(--soft); }
.tile .now { font-size: 23px; font-weight: 700; line-height: 1.3; font-variant-numeric: tabular-nums; }
.tile .was { font-size: 13px; color: var(--soft); }
.better { color: var(--good); font-weight: 600; }
.worse { color: var(--bad); font-weight: 600; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(320px, 100%), 1fr)); gap: 18px; align-items: end; }
.thirds { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(280px, 100%), 1fr)); gap: 14px; }
figure { margin: 0; }
.pair figure:only-child { max-width: 620px; width: 100%; margin: 0 auto; }
figcaption { font-size: 14px; color: var(--soft); text-align: center; }
figcaption b { color: var(--ink); }
svg { display: block; width: 100%; height: auto; }
svg.part { max-height: 480px; }
svg.sphere { max-width: 460px; margin: 0 auto; }
svg.bar { max-width: 340px; }
svg text { fill: var(--soft); font-size: 12px; font-family: inherit; }
svg .dim { fill: var(--ink); font-weight: 600; font-size: 13px; }
.plate { fill: var(--plate); stroke: var(--line); }
.grid { fill: none; stroke: var(--line); stroke-width: 1; }
.ruler { fill: none; stroke: var(--soft); stroke-width: 1.2; }
.rim { fill: var(--faint); stroke: var(--line); stroke-width: 1.5; }
.lines { fill: none; stroke: var(--line); stroke-width: 1; }
.curve { stroke-width: 2; stroke-linejoin: round; }
.curve.chosen { fill: var(--chosen); fill-opacity: .22; stroke: var(--chosen); }
.curve.delivered { fill: var(--delivered); fill-opacity: .16; stroke: var(--delivered); stroke-dasharray: 5 3; }
.badge circle { fill: #ffffff; stroke: #17212b; stroke-width: 1.6; }
.badge text { fill: #17212b; font-size: 12px; font-weight: 700; }
.badge.chosen circle { fill: #0b6fbf; stroke: #ffffff; stroke-width: 2; }
.badge.chosen text { fill: #ffffff; font-size: 13px; }
.badge.delivered circle { fill: #3d4853; stroke: #ffffff; }
.badge.delivered text { fill: #ffffff; }
.marks .can { stroke: var(--ink); stroke-width: 1.4; }
.leader { fill: none; stroke: #17212b; stroke-width: 1.6; }
@media (prefers-color-scheme: dark) { .leader { stroke: #e8edf2; } }
.legend { display: flex; flex-wrap: wrap; gap: 6px 20px; align-items: center; font-size: 14px; color: var(--soft); margin: 14px 0 0; padding: 0; list-style: none; }
.legend span.key { display: inline-block; width: 14px; height: 14px; border-radius: 4px; margin-right: 7px; vertical-align: -2px; }
.scroll { overflow-x: auto; margin: 0 -20px; padding: 0 20px; }
table { border-collapse: collapse; width: 100%; font-size: 14px; font-variant-numeric: tabular-nums; }
th { text-align: right; font-weight: 600; color: var(--soft); padding: 6px 9px; border-bottom: 1px solid var(--line); white-space: nowrap; }
td { text-align: right; padding: 8px 9px; border-bottom: 1px solid var(--line); white-space: nowrap; }
th.name, td.name { text-align: left; white-space: normal; min-width: 170px; }
td.name small { display: block; color: var(--soft); font-size: 12.5px; }
tr:last-child td { border-bottom: 0; }
tr.chosen td { background: color-mix(in srgb, var(--chosen) 9%, transparent); }
.mark { display: inline-block; min-width: 24px; height: 24px; line-height: 22px; text-align: center; border-radius: 12px; border: 1.5px solid var(--soft); font-size: 12px; font-weight: 700; }
.mark.chosen { background: var(--chosen); border-color: var(--chosen); color: var(--card); }
.mark.delivered { background: #3d4853; border-color: #3d4853; color: #ffffff; }
.time { position: relative; min-width: 96px; }
.time i { display: block; height: 5px; border-radius: 3px; background: var(--delivered); margin: 3px 0 0 auto; }
tr.chosen .time i { background: var(--chosen); }
footer { color: var(--soft); font-size: 13px; max-width: 90ch; }
@media (max-width: 640px) {
  main { padding: 18px 12px 32px; }
  section { padding: 16px 14px; }
  .scroll { margin: 0 -14px; padding: 0 14px; }
  .tiles { grid-template-columns: 1fr 1fr; gap: 8px; }
}
@media print { body { background: #ffffff; } section, .tile { break-inside: avoid; } }
)";
}

}  // namespace voidpath::report
