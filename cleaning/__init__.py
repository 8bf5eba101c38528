"""What the jet achieves: exposure, flow under components, residue, rinse, drying, verdicts.

``analyse.analyse`` is the whole of it: program, board, recipe and parameters in, a ``results.CleaningReport`` out. Its
formulas stand by themselves, so that each can be asked alone. SI units, except where a name ends in another (``_mm``,
``_um``, ``_c``, ``_bar``); numbers that mean nothing raise ``errors.CleaningError``.

- Spray: ``footprint.footprint`` of a cone on a tilted plane; ``impact.flow_m3_s``, ``liquid_speed_m_s`` and
  ``total_impact_n``; ``jet.jet_of`` a stage, its ``jet.intensity`` by direction and ``jet.stress_at`` a wall.
- Film and edges: ``film.film_momentum`` from the rim of the spray, ``pressure.edge_pressures`` on the undersides.
- Entry: ``liquid.capillary_pa`` and ``fill_time_s``, ``entry.entry_margin`` of a component.
- Flow in gaps: ``gap_solve.solve`` on a ``gap_grid.plain_grid`` between pressures on its rim and on holes inside;
  ``gap.solve_gap`` for a package with its joints; ``posts.round_posts``, ``tall_posts``, ``post_factor`` and
  ``duct_factor`` for what stands in the way; ``inertia.inertial``; ``saturation.saturation`` on the way;
  ``front.fill`` and ``front_m`` for liquid that comes in.
- Residue: ``fill.fill_share`` before the wash, ``kinetics.softening_rate``, ``removal_rate`` and ``step``,
  ``washing.under_component`` for one gap through all stages.
- Rinse and drying: ``rinse.diluted_g_m3`` and ``ionic_ug_cm2``; ``drying.blow_off_m``, ``film_dry_s`` and
  ``gap_dry_s``; ``humid_air.wet_surface_c``.
"""
