// Indifferent: walks the stations and ignores the gantry.

{ include("patrol.asl") }
