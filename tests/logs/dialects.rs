//! Logs as other tools write them, by the line.

use crate::rig::{read_text, try_text};

#[track_caller]
fn lines(name: &str, text: &str) -> Vec<String> {
    read_text(name, text).lines()
}

#[test]
fn candump_in_log_form() {
    let text = "\
(1436509052.249713) vcan0 044#2A366C2BBA
(1436509052.449847) vcan0 0F6#7ADFE07BD2
(1436509052.650004123) can1 1DEFFFCC#C0083B9FF0819C51 T
(1436509053.650004) can1 123## R
(1436509053) can1 123##1AABB
(1436509053.650004) can1 123##3.AA.BB
(1436509053.650004) can1 123##500112233445566778899AABB R
(1436509053.650004)  can1 123#R
(1436509053.650004) can1 123#R5
(1436509053.650004) can1 123#R8_B
(1436509053.650004) can1 123#0011223344556677_E
(1436509053.650004) can1 20000088#0000010000000102
# a comment

";
    let (log, findings) = try_text("x.log", text);
    assert_eq!(findings, ["4:31: expected the flags of a CAN FD frame, a digit"]);
    assert_eq!(
        log.lines(),
        [
            "1436509052249713000 vcan0 Received 044#2A366C2BBA",
            "1436509052449847000 vcan0 Received 0F6#7ADFE07BD2",
            "1436509052650004123 can1 Sent 1DEFFFCC#C0083B9FF0819C51",
            "1436509053000000000 can1 Received 123##1AABB",
            "1436509053650004000 can1 Received 123##1AABB ESI",
            "1436509053650004000 can1 Received 123##100112233445566778899AABB",
            "1436509053650004000 can1 Received 123#R0",
            "1436509053650004000 can1 Received 123#R5",
            "1436509053650004000 can1 Received 123#R8_B",
            "1436509053650004000 can1 Received 123#0011223344556677_E",
            "1436509053650004000 can1 Received error 88 [00, 00, 01, 00, 00, 00, 01, 02]",
        ]
    );
}

#[test]
fn candump_in_screen_form() {
    let text = concat!(
        "  can0  123   [8]  11 22 33 44 55 66 77 88\n",
        "  can0  0DF11380   [3]  00 D6 4B   '..K'\n",
        " (1436509052.249713)  vcan0  TX - -  123   [2]  AA BB\r\n",
        " (1436509052.249713)  vcan0  RX B E  123  [08]  11 22 33 44 55 66 77 88\n",
        " (2015-07-10 06:17:32.249713)  can0       123   [0] \n",
        "  can0  123   [4]  remote request\n",
        "  can0  20000004   [8]  00 04 00 00 00 00 00 00   ERRORFRAME\n",
        "\tcontroller-problem{rx-error-warning}\n",
        "  can0  123   [2]  00010001 11110000\n",
        "  can0  123   [3]  33`22`11\n",
        "  can0  123   {C}  11 22 33 44 55 66 77 88\n",
        " \x1b[34m (000.000001)  can0  123   [1]  01\x1b[0m\n",
        "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 17)\n",
        "<0x18eeff01> [2] 05 a0 \n",
    );
    assert_eq!(
        lines("screen.txt", text),
        [
            "0 can0 Received 123#1122334455667788",
            "0 can0 Received 0DF11380#00D64B",
            "1436509052249713000 vcan0 Sent 123#AABB",
            "1436509052249713000 vcan0 Received 123##11122334455667788 ESI",
            "1436509052249713000 can0 Received 123#",
            "1436509052249713000 can0 Received 123#R4",
            "1436509052249713000 can0 Received error 4 [00, 04, 00, 00, 00, 00, 00, 00]",
            "1436509052249713000 can0 Received 123#11F0",
            "1436509052249713000 can0 Received 123#112233",
            "1436509052249713000 can0 Received 123#1122334455667788_C",
            "1000 can0 Received 123#01",
            "1000 can0 Received lost 3",
            "1000 can0 Received 18EEFF01#05A0",
        ]
    );
}

#[test]
fn candump_with_stamps_since_the_frame_before() {
    let since_before = " (000.000000)  can0  1   [0]\n (000.200000)  can0  1   [0]\n (000.100000)  can0  1   [0]\n";
    let stamps = |text: &str| {
        lines("x.txt", &text.replace("  1   ", "  001   "))
            .iter()
            .map(|line| line.split(' ').next().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    assert_eq!(stamps(since_before), ["0", "200000000", "300000000"]);
    let since_first = since_before.replace("000.100000", "000.300000");
    assert_eq!(stamps(&since_first), ["0", "200000000", "300000000"]);
}

#[test]
fn a_log_without_stamps_is_said_to_be_one() {
    let (log, findings) = try_text("x.txt", "  can0  09F8027F   [1]  00\n  can0  09F8017F   [1]  E8\n");
    assert_eq!(log.records.len(), 2);
    assert_eq!(findings, ["1:1: there are no stamps in this log: all its frames are at 0 s"]);
}

#[test]
fn asc_of_canoe_and_python_can() {
    let text = "\
date Sam Sep 30 15:06:13.191 2017
base hex  timestamps absolute
internal events logged
// version 9.0.0
//0.000000 previous log file: logfile_errorframes.asc
Begin Triggerblock Sam Sep 30 15:06:13.191 2017
   0.000000 Start of measurement
   0.015991 CAN 1 Status:chip status error passive - TxErr: 132 RxErr: 0
   1.015991 1  Statistic: D 0 R 0 XD 0 XR 0 E 0 O 0 B 0.00%
   1.015992 J1939TP FEE3p 6 0 0 - Rx d 23 A0 0F A6 60 3B D1 40 1F DE 80 25 60 22 00 E1
   2.5010 1 ErrorFrame
   2.501010 1 ErrorFrame ECC: 10100010
   2.501020 2 ErrorFrame Flags = 0xe CodeExt = 0x20a2 Code = 0x82 ID = 0 DLC = 0 Position = 5
   3.000000 1  18EBFF00x       Rx   d 8 01 A0 0F A6 60 3B D1 40  Length = 273910 BitCount = 141 ID = 418119424x
   3.000001 2  6F9             Tx   d f 05 0C 00 00 00 00 00 00
   3.000002 1  300             Rx   r
   3.000003 1  300             Rx   r 8 Length = 2180000 BitCount = 112 ID = 768
   3.000004 1  300             TxRq d 1 00
   3.000005 CANFD   1 Rx        300                                  1 0 8  8 12 C2 F7 E5 15 61 2C 0C   130000  130   303000 e0006659 46500250 4b140250 20011736 2001040d
   3.000006 CANFD   2 Tx        1C4D80A7x  EngineData                0 1 9 12 00 01 02 03 04 05 06 07 08 09 0A 0B  103000  214     5000 0 0 0 0 0
   3.000007 CANFD   1 Rx        30005x                               0 0 5  0 140000  73       200050 7a60 46500250 460a0250 20011736 20010205
   3.000008 CANFD   3 Rx        ErrorFrame                  Not Acknowledge error, dominant error flag fffe c7 31ca 0 0
   4.0 SV: 0 0 0 ::System::Var = 1
End TriggerBlock
";
    let (log, findings) = try_text("x.asc", text);
    assert_eq!(findings, ["1:1: lines with TxRq tell what was asked to be sent: they are left out"]);
    let unspecified = "error 80 [00, 00, 00, 00, 00, 00, 00, 00]";
    assert_eq!(
        log.lines(),
        [
            format!("1506783975692000000 can0 Received {unspecified}"),
            format!("1506783975692010000 can0 Received {unspecified}"),
            format!("1506783975692020000 can1 Received {unspecified}"),
            "1506783976191000000 can0 Received 18EBFF00#01A00FA6603BD140".to_owned(),
            "1506783976191001000 can1 Sent 6F9#050C000000000000_F".to_owned(),
            "1506783976191002000 can0 Received 300#R0".to_owned(),
            "1506783976191003000 can0 Received 300#R8".to_owned(),
            "1506783976191005000 can0 Received 300##112C2F7E515612C0C".to_owned(),
            "1506783976191006000 can1 Sent 1C4D80A7##0000102030405060708090A0B ESI".to_owned(),
            "1506783976191007000 can0 Received 00030005#R5".to_owned(),
            format!("1506783976191008000 can2 Received {unspecified}"),
        ]
    );
}

#[test]
fn asc_in_decimal_with_relative_times() {
    let text = "date Mon Jan 01 12:00:00 am 2024\r\nbase dec  timestamps relative\r\nno internal events logged\r\n\
                0.5 1  100             Rx   d 2 255 016\r\n0.25 1  100x            Rx   d 0\r\n";
    assert_eq!(
        lines("x.asc", text),
        ["1704067200500000000 can0 Received 064#FF10", "1704067200750000000 can0 Received 00000064#"]
    );
}

#[test]
fn trc_of_every_version() {
    let v1_0 = "\
;##########################################################################
;   D:\\trace.trc
;    Start time: N/A
;---+-- ----+---- --+-- + -+ -- -- --
     1)      1841 0001 8 00 00 00 00 00 00 00 00
     2)      1842 00000100 2 AA BB
     3)      1843 0200 4 RTR
     4)      1844 FFFFFFFF 4 00 00 00 04
";
    assert_eq!(
        lines("x.trc", v1_0),
        [
            "1841000000 can0 Received 001#0000000000000000",
            "1842000000 can0 Received 00000100#AABB",
            "1843000000 can0 Received 200#R4"
        ]
    );
    let v1_1 = ";$FILEVERSION=1.1\r\n;$STARTTIME=44083.5916273148\r\n;   Start time: 09.09.2020 14:11:56.600.0\r\n\
                \r\n     1)      1059.9  Rx         0300  7  00 00 00 00 04 00 00\r\n\
                     2)      1060.0  Warng  FFFFFFFF  4  00 00 00 08  BUSHEAVY\r\n\
                     3)      1061.2  Error      0008  4  00 19 08 09\r\n     4)      1062.2  Tx     00000100  0\r\n";
    assert_eq!(
        lines("x.trc", v1_1),
        [
            "1599660717659900000 can0 Received 300#00000000040000",
            "1599660717661200000 can0 Received error 88 [00, 00, 00, 19, 00, 00, 09, 08]",
            "1599660717662200000 can0 Sent 00000100#",
        ]
    );
    let v1_3 = ";$FILEVERSION=1.3\n;$STARTTIME=25569.0\n     1)      1059.900 2  Rx        0300 -  2    AB CD \n";
    assert_eq!(lines("x.trc", v1_3), ["1059900000 can1 Received 300#ABCD"]);
    let v2_0 = ";$FILEVERSION=2.0\n;$STARTTIME=25569.0\n;$COLUMNS=N,O,T,I,d,l,D\n\
                1      1.5 DT     0300 Rx 2  AB CD\n2      2.5 FB 18EFC034 Tx 12 01 02 03 04 05 06 07 08 09 0A 0B 0C\n3 3.5 RR 0400 Rx 8\n";
    assert_eq!(
        lines("x.trc", v2_0),
        [
            "1500000 can0 Received 300#ABCD",
            "2500000 can0 Sent 18EFC034##10102030405060708090A0B0C",
            "3500000 can0 Received 400#R8"
        ]
    );
    let v2_1 = ";$FILEVERSION=2.1\n;$STARTTIME=25569.0\n;$COLUMNS=N,O,T,B,I,d,R,L,D\n\
                1      1.500 DT 1      0300 Rx -  2    AB CD\n2      2.500 FE 2      0300 Tx -  9    01 02 03 04 05 06 07 08 09 0A 0B 0C\n\
                3 3.500 ST 1     -  Rx -  4    00 00 00 08\n4 4.5 ER 1 - Rx - 5 04 00 02 00 07\n5 5.5 EC 1 - Rx - 2 00 01\n6 6.5 EV User pressed a key\n7 7.5 BI 1 0001 Rx - 0\n";
    assert_eq!(
        lines("x.trc", v2_1),
        [
            "1500000 can0 Received 300#ABCD",
            "2500000 can1 Sent 300##10102030405060708090A0B0C ESI",
            "4500000 can0 Received error 88 [00, 00, 04, 02, 00, 00, 07, 00]",
            "7500000 can0 Received 001##0 ESI",
        ]
    );
}

#[test]
fn csv_of_python_can_and_savvycan() {
    let python = "timestamp,arbitration_id,extended,remote,error,dlc,data\n\
                  1483389946.197,0xdadada,1,0,0,6,WzQyLCA5XQ==\n1e-05,0x1,0,1,0,4,\n2.5,0x0,1,0,1,0,\n";
    let (log, findings) = try_text("x.csv", python);
    assert_eq!(findings, ["2:33: found `WzQyLCA5XQ==`, expected as much data as the length says"]);
    assert_eq!(
        log.lines(),
        ["10000 can0 Received 001#R4", "2500000000 can0 Received error 80 [00, 00, 00, 00, 00, 00, 00, 00]"]
    );
    let gvret = "Time Stamp,ID,Extended,Dir,Bus,LEN,D1,D2,D3,D4,D5,D6,D7,D8\n\
                 166064000,0000021A,false,Rx,0,8,FE,36,12,FE,69,05,07,AD,\n166064350,18FEF1FE,true,Tx,1,1,C0,\n";
    assert_eq!(
        lines("x.csv", gvret),
        ["166064000000 can0 Received 21A#FE3612FE690507AD", "166064350000 can1 Sent 18FEF1FE#C0"]
    );
}

#[test]
fn busmaster_and_carbus_analyzer() {
    let busmaster = "***BUSMASTER Ver 3.2.2***\n***PROTOCOL CAN***\n***[START LOGGING SESSION]***\n\
                     ***START DATE AND TIME 26:3:2020 23:59:59:625***\n***HEX***\n***SYSTEM MODE***\n\
                     ***START DATABASE FILES (DBF/DBC)***\nC:\\a.dbf\n***END DATABASE FILES (DBF/DBC)***\n\
                     ***<Time><Tx/Rx><Channel><CAN ID><Type><DLC><DataBytes>***\n\
                     23:59:59:6265 Rx 1 0x21A s 2 FE 36\n00:00:01:0000 Tx 2 0x18FEF1FE x 0\n00:00:01:0001 Rx 1 0x21A sr 4\n\
                     00:00:01:0002 Rx 1 ERR\n00:00:01:0003 Rx 1 0x1 s-fd 12 0 1 2 3 4 5 6 7 8 9 A B\n0:0:1:4 Rx 1 0x1 s 0\n***[STOP LOGGING SESSION]***\n";
    assert_eq!(
        lines("x.log", busmaster),
        [
            "1585267199626500000 can0 Received 21A#FE36",
            "1585267201000000000 can1 Sent 18FEF1FE#",
            "1585267201000100000 can0 Received 21A#R4",
            "1585267201000200000 can0 Received error 80 [00, 00, 00, 00, 00, 00, 00, 00]",
            "1585267201000300000 can0 Received 001##0000102030405060708090A0B",
            "1585267201004000000 can0 Received 001#",
        ]
    );
    let carbus = "@ TEXT @ 2 @ 64 @ 0 @ 55 @ 10078 @ 00:00:10.078 @\r46,016\t1\t0004\t45A\t2\t5A 04\t00000000\tZ \t\r";
    assert_eq!(lines("x.trc", carbus), ["46016000000 can0 Received 45A#5A04"]);
}
